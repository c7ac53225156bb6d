//! Simulation of people in front of an event camera, with joint labels.
//!
//! * [`PeopleConfig`]: everything but the seed.
//! * [`People`]: a run and the state shared by its sequences; [`PersonSimulator`]: one sequence,
//!   step by step.
//! * [`Still`]: photographs of people, for pre-training.
//! * [`record_people`]: sequences as files, with [`PoseTable`]s of labels beside them.
//!
//! A sequence is one person, one activity and one background, all drawn anew for each sequence. The
//! person stands in front of a background plane with an image, before which distractors may move;
//! the camera is fixed or held by hand.

mod background_plane;
mod camera_path;
mod cast_member;
mod config;
mod distractor;
mod joints;
mod luminance_image;
mod people;
mod place;
mod pose_table;
mod record;
mod scene_instance;
mod shared;
mod simulator;
mod still;

pub use config::{Framing, PeopleConfig, SurroundingsConfig};
pub use joints::BodyJoints3;
pub use people::People;
pub use place::RecordingPlace;
pub use pose_table::{PoseRow, PoseTable};
pub use record::{PersonInfo, RecordedPeople, record_people};
pub use simulator::{PersonSimulator, PersonStep};
pub use still::Still;
