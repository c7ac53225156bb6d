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
pub use stillness::{StillnessConfig, StillnessGate};
