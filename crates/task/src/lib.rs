//! Pose tasks: experiments, checkpoints, predictors, and the stream from events to poses.
//!
//! * [`PoseStream`](evpose_pose::stream::PoseStream): events → representation → network → decoding
//!   → filter → pose.
//! * [`TaskConfig`]: reading, checking, comparing and writing the config of any task.
//! * [`hand`], [`body`]: configs, checkpoints, predictors and front ends of the two tasks.
//! * [`baseline`]: the same of the networks that MoveEnet is compared with.
//! * [`QuantizationRanges`]: calibration of int8 inference, for any network.
//! * [`schedule`]: learning rates over a training, early stopping.
//! * [`FieldDifference`]: the fields in which two configs differ.
//!
//! ```
//! use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
//! use evpose_pose::HandParams;
//! use evpose_task::TaskConfig as _;
//! use evpose_task::hand::{ConstantPose, HandConfig, poses_every_ms};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let config = HandConfig::parse("task = \"hand\"\n[representation]\nwindow_ms = 50", &[])?;
//! let mut events = EventStream::empty(SensorSize { width: 32, height: 24 });
//! for ms in 0..60 {
//!     events.push(Event { t: Micros(1_000 * ms), x: ms as u16 % 32, y: 7, polarity: Polarity::On })?;
//! }
//! // A network takes the place of the constant: see `NetworkPredictor`.
//! let mut predictor = ConstantPose(HandParams::default());
//! let poses = poses_every_ms(&config, &events, &mut predictor, &mut |_| {})?;
//! assert_eq!(poses.len(), 10);
//! // Of the events before 51 ms.
//! assert_eq!(poses[0].t, Micros(51_000));
//! # Ok(())
//! # }
//! ```

pub mod baseline;
pub mod body;
mod config;
mod differences;
mod error;
pub mod hand;
mod quantized;
pub mod schedule;

pub use config::TaskConfig;
pub use differences::FieldDifference;
pub use error::TaskError;
pub use quantized::QuantizationRanges;
