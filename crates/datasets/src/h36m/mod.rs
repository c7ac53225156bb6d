//! eH3.6M: the videos of Human3.6M as events, and how more of it is made.
//!
//! * As published, folders of YARP logs: [`published_clips`], [`read_published`].
//! * From the original data set: [`original_clips`], [`read_poses`], [`Crop`] for the part of the
//!   video, [`events_of_frames`] for its events and [`bodies_of_poses`] for the joints;
//!   [`write_published`] writes both as published.
//!
//! # Source
//! Goyal et al., *MoveEnet: Online High-Frequency Human Pose Estimation with an Event Camera*,
//! CVPRW 2023, Sec. 4.1.2; hpe-core, `datasets/h36m`. Ionescu et al., *Human3.6M*, PAMI 2014.

mod clip_name;
mod crop;
mod joints;
mod listing;
mod poses;
mod published;
mod resize;
mod synthesis;
mod write;

use evpose_core::SensorSize;

pub use clip_name::{ClipName, FRONT_CAMERAS, SUBJECTS, TEST_SUBJECTS};
pub use crop::{Crop, CropRule};
pub use joints::{H36M_JOINTS, H36mPose, body_points};
pub use listing::{original_clips, published_clips};
pub use poses::read_poses;
pub use published::{Clip, read_published};
pub use synthesis::{Synthesis, bodies_of_poses, events_of_frames};
pub use write::write_published;

/// The event camera.
pub const SENSOR: SensorSize = SensorSize { width: 640, height: 480 };
/// Frames and poses a second.
pub const FPS: f64 = 50.0;

#[cfg(test)]
mod tests;
