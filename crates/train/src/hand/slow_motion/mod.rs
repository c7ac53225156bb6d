//! The slow-motion mode: poses where events trigger them, instead of one every millisecond.
//!
//! # Model
//! A trigger samples an input when enough time has passed *and* enough events have come
//! ([`RepresentationTrigger`](evpose_repr::RepresentationTrigger)). Inputs are gathered in batches.
//! A full batch is predicted, or gets the previous predictions where the scene is at rest
//! ([`StillnessGate`](evpose_pose::filter::StillnessGate)). Each pose goes through a Kalman filter
//! with two settings, at the time stamp of its input
//! ([`AdaptiveHandFilter`](evpose_pose::filter::AdaptiveHandFilter)).
//!
//! A pose is known when its batch is full: up to 16 ms after its input while the hand moves fast,
//! and later the slower it moves.
//!
//! # Source
//! EventHands, supplement and live pipeline. There the first inputs hold less than a window of
//! events; here inputs begin when the first window is full.

mod evaluate;

pub use evaluate::{SlowMotionResults, SlowMotionUsage, evaluate_slow_motion};
