//! The slow-motion mode: poses where there is something to see, instead of one every millisecond.
//!
//! # Model
//! A trigger makes a surface when enough time has passed *and* enough events have come
//! ([`RepresentationTrigger`](evpose_repr::RepresentationTrigger)). Surfaces are gathered in batches. A full batch
//! is predicted, or gets the previous predictions where the scene is at rest
//! ([`StillnessGate`](evpose_pose::filter::StillnessGate)). Each pose goes through a Kalman filter
//! with two settings, at the time of its surface
//! ([`AdaptiveHandFilter`](evpose_pose::filter::AdaptiveHandFilter)).
//!
//! A pose is known when its batch is full: up to 16 ms after its surface while the hand moves fast,
//! and later the slower it moves.
//!
//! # Source
//! EventHands, supplement and live pipeline. There the first surfaces show less than a window of
//! events; here surfaces begin when the first window is full.

mod evaluate;

pub use evaluate::{SlowMotionResults, SlowMotionUsage, evaluate_slow_motion};
