//! DHP19: 33 movements of 17 persons, seen by four event cameras, with markers from motion capture.
//!
//! ```text
//! DVS_movies/S1/session2/mov5.aedat   read_movie, cut_movement
//! Vicon_data/S1_2_5.mat               read_vicon
//! P1.npy .. P4.npy                    Projection
//! S1_2_5.mat                          read_extracted: the movie, cut by the published programs
//! ```
//!
//! A [`Movement`] is what the cameras saw from the beginning to the end; [`Movement::seen_by`] is
//! what one of them saw, a [`LabelledRecording`](crate::LabelledRecording) with the joints on its
//! image. [`KNOWN_FAULTS`] says what is wrong with the set.
//!
//! Images are the right way round: column 0 is at the left, row 0 at the top, as the published
//! programs turn them.
//!
//! # Source
//! Calabrese et al., *DHP19: Dynamic Vision Sensor 3D Human Pose Dataset*, CVPRW 2019, and the
//! programs published with it; hpe-core, `datasets/dhp19`.

mod background;
mod camera;
mod extracted;
mod filters;
mod movement;
mod movie;
mod projection;
mod recording_name;
mod span;
mod vicon;

pub use background::{BackgroundFilter, NeighbourRule};
pub use camera::{CAMERAS, CameraChoice, PROJECTION_FILES, SENSOR};
pub use extracted::read_extracted;
pub use filters::{CameraMask, Dhp19Filters, MASKS, Removed};
pub use movement::{Movement, cut_movement};
pub use movie::{Movie, read_movie};
pub use projection::{PixelRule, Projection};
pub use recording_name::{Dhp19Name, KNOWN_FAULTS, KnownFault, MOVEMENTS, SUBJECTS, TEST_SUBJECTS};
use span::movement_span;
pub use span::{Span, SpanOrigin};
pub use vicon::{POSE_INTERVAL, Pose, read_vicon};

#[cfg(test)]
mod tests;
