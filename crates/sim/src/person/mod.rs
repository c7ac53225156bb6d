//! People before an event camera, simulated and labelled.
//!
//! * [`PeopleConfig`]: everything but the seed.
//! * [`People`]: a run, with what its sequences share; [`PersonSimulator`]: one sequence, step by step.
//! * [`Still`]: photographs of people, for pre-training.
//! * [`record_people`]: sequences as files, with [`PoseTable`]s of labels beside them.
//!
//! A sequence is one person doing one thing in one place, so every sequence shows somebody else. The
//! person stands on the floor before a wall with a picture on it, before which things may move; the
//! camera stands still or is held by hand.

mod camera_path;
mod config;
mod joints;
mod people;
mod pose_table;
mod record;
mod simulator;
mod still;
mod take;
mod wall;

pub use config::{PeopleConfig, SurroundingsConfig};
pub use joints::BodyJoints3;
pub use people::People;
pub use pose_table::{PoseRow, PoseTable};
pub use record::{PersonInfo, RecordedPeople, record_people};
pub use simulator::{PersonSimulator, PersonStep};
pub use still::Still;
