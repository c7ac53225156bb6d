//! Inputs of the workflow: a scene directory and a recording, and checks that they fit together.
//!
//! * [`load_scene`]: `scene.json` with `frames.npy` or `frames/`.
//! * [`load_recording`]: events of any format.
//! * [`Problems`]: wrong size, duration, start, unit of time, orientation or polarity. They are
//!   detected and reported before anything is compared, and corrected on request.

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
