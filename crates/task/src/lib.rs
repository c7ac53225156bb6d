//! Pose tasks: experiments, checkpoints, predictors, and the stream from events to poses.
//!
//! * [`PoseStream`](evpose_pose::stream::PoseStream): events → representation → network → decoding
//!   → filter → pose. [`RecordingStream`]: a recording through it.
//! * [`hand`], [`body`]: configs, checkpoints, predictors and front ends of the two tasks.
//! * [`baseline`]: the same of the networks that MoveEnet is compared with.
//! * [`network_file()`]: finished networks of a run directory.
//! * [`QuantizationRanges`]: calibration of int8 inference, for any network.
//! * [`schedule`]: learning rates over a training, early stopping.
//! * [`Experiment`]: the config of any task, read, checked, compared and written; [`FieldDifference`]: the fields in
//!   which two of them differ.
//!
//! ```
//! use evpose_core::Micros;
//! use evpose_io::{Input, OpenOptions, Windows};
//! use evpose_pose::HandParams;
//! use evpose_pose::stream::InferenceSchedule;
//! use evpose_task::{RecordingStream, Experiment as _};
//! use evpose_task::hand::{ConstantPose, HandConfig, hand_stream};
//! use evpose_camera::Calibration;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let config = HandConfig::parse("task = \"hand\"\n[representation]\nwindow_ms = 50", &[])?;
//! // Seconds, column, row, polarity.
//! let mut text = "32 24\n".to_owned();
//! (0..60).for_each(|ms| text += &format!("{:.3} {} 7 1\n", 1e-3 * f64::from(ms), ms % 32));
//! let options = OpenOptions::default();
//! let file = Input::memory("a.txt", text.into_bytes());
//! let windows = Windows::from_source(evpose_io::source(file, &options)?.1, &options)?;
//! let every_ms = InferenceSchedule::Every(Micros(1_000));
//! // A network takes the place of the constant: see `NetworkPredictor`.
//! let predictor = ConstantPose(HandParams::default());
//! let camera = Calibration::guessed(windows.sensor());
//! let stream = hand_stream(&config, predictor, &camera, every_ms, 1)?;
//! let mut poses = Vec::new();
//! for inferred in RecordingStream::new(windows, stream, every_ms) {
//!     poses.extend(inferred?.poses);
//! }
//! assert_eq!(poses.len(), 10);
//! // Of the events before 51 ms.
//! assert_eq!(poses[0].0, Micros(51_000));
//! # Ok(())
//! # }
//! ```

pub mod baseline;
pub mod body;
mod differences;
mod error;
mod event_steps;
mod experiment;
pub mod hand;
mod network_file;
mod quantized;
mod ranges;
mod recording_stream;
pub mod schedule;

pub use differences::FieldDifference;
pub use error::TaskError;
pub use experiment::{Experiment, NetworkInput};
pub use network_file::{BEST, LAST, network_file};
pub use quantized::QuantizationRanges;
pub use recording_stream::{InferredPoses, MAX_SILENCE, RecordingStream};
