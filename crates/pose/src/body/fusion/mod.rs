//! Fusion of a network's detections with velocities measured from events.
//!
//! A network needs tens of milliseconds for a pose, which is then as old. Velocities come hundreds
//! of times a second and almost without latency, but without positions. [`BodyFusion`] takes both
//! and estimates joints at any time: each detection is applied at the *event time stamp of its
//! input*, and the velocities since then are applied again (out-of-sequence measurements).
//!
//! * [`BodyFusion`]: detections and velocities in, joints out.
//! * [`FusionConfig`], [`Estimator`]: the estimator of a joint and its noise.
//! * [`ScoredPoints`], [`ConfidenceTest`]: detections, and the scores from which they are accepted.
//!
//! ```
//! use evpose_core::Micros;
//! use evpose_pose::body::BODY_JOINTS;
//! use evpose_pose::body::fusion::{BodyFusion, FusionConfig, ScoredPoints};
//! use glam::Vec2;
//!
//! let mut fusion = BodyFusion::new(&FusionConfig::default())?;
//! let points = [Some(Vec2::new(100.0, 80.0)); BODY_JOINTS];
//! let pose = ScoredPoints { points, scores: [0.9; BODY_JOINTS] };
//! // A pose of 20 ms, found at 60 ms; all joints have moved to the right since.
//! for ms in 0..30 {
//!     fusion.velocity(Micros(2_000 * ms), &[Vec2::new(300.0, 0.0); BODY_JOINTS])?;
//! }
//! fusion.detection(Micros(20_000), &pose, Micros(60_000))?;
//! let head = fusion.query(Micros(60_000))[0].expect("just seen");
//! assert!(head.x > 108.0 && head.x < 113.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod body;
mod confidence;
mod config;
mod constant_position;
mod constant_velocity;
mod displacement;
mod error;
mod filter;
#[cfg(test)]
mod golden;
mod integration;
mod published;
#[cfg(test)]
mod simulated;
mod time_order;

pub use body::BodyFusion;
pub use confidence::{ConfidenceTest, ScoredPoints};
pub use config::{Estimator, FusionConfig};
pub use error::FusionError;
