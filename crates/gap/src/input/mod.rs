//! What the workflow is given: a scene directory and a recording, and what does not fit together.
//!
//! * [`load_scene`]: `scene.json` with `frames.npy` or `frames/`.
//! * [`load_recording`]: events of any format.
//! * [`Problems`]: size, duration, start, unit of time, orientation and polarity, found before
//!   anything is compared, said, and repaired only where that is asked for.

mod description;
mod problems;
mod recording;
mod scene_dir;
pub mod units;

pub use evpose_clean::symmetry::{self, Orientation, Symmetry};

pub use description::{Description, Nominal};
pub use problems::{Problem, Problems};
pub use recording::{LoadedRecording, load_recording};
pub use scene_dir::{LoadedScene, load_scene};

#[cfg(test)]
mod tests;
