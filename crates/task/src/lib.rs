//! Pose tasks: experiments, checkpoints, predictors, and the stream from events to poses.
//!
//! * [`PoseStream`](evpose_pose::stream::PoseStream): events → representation → network → decoding → filter → pose.
//! * [`hand`], [`body`]: configs, checkpoints, predictors and front ends of the two tasks.
//! * [`QuantizationRanges`]: calibration of int8 inference, for any network.
//! * [`FieldDifference`]: the fields in which two configs differ.

pub mod body;
mod differences;
mod error;
pub mod hand;
mod quantized;
pub mod toml_text;

pub use differences::FieldDifference;
pub use error::TaskError;
pub use quantized::QuantizationRanges;
