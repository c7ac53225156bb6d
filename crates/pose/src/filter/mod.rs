//! Filters that smooth poses over time, one measurement at a time and without looking ahead.
//!
//! * [`ConstantVelocityKalman`]: any number of independent values, each with a velocity.
//! * [`HandFilter`]: the same on the 12 parameters of a hand, without tearing its rotation at π.
//! * [`AdaptiveHandFilter`]: one that smooths more while the hand moves slowly.
//! * [`BodyFilter`]: the same on the joints of a body, whose noise follows their scores.
//! * [`StillnessGate`]: predictions of a scene at rest are repeated.

mod adaptive;
mod body;
mod config;
#[cfg(test)]
mod golden;
mod hand;
mod hold;
mod kalman;
mod stillness;

pub use adaptive::{AdaptiveFilterConfig, AdaptiveHandFilter};
pub use body::{BodyFilter, BodyFilterConfig};
pub use config::{HandNoise, InitialState, KalmanConfig, NoiseSetting, NoiseVariances, TimeStep};
pub use hand::{HandFilter, HandFilterConfig};
pub use hold::HoldAtRest;
pub use kalman::ConstantVelocityKalman;
pub use stillness::{Gated, StillnessConfig, StillnessGate};

use evpose_core::Micros;

/// A causal filter over vectors of a fixed length.
pub trait TemporalFilter {
    /// Takes the measurement `z` of time `t` and writes the estimate for the same time to `out`.
    ///
    /// A measurement that is not finite counts as missing: the estimate is then the prediction, or
    /// the measurement itself where there was none before.
    ///
    /// # Panics
    /// If `z` or `out` has another length than the filter was made for.
    fn update(&mut self, t: Micros, z: &[f32], out: &mut [f32]);

    /// Forgets every measurement.
    fn reset(&mut self);
}
