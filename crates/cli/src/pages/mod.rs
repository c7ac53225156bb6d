//! Pages and images of results.
//!
//! * [`hand`]: the report of an experiment with hands; [`held_out`]: the table of an evaluation.
//! * [`people`], [`camera_views`], [`hand_scene`]: images of people and of simulated scenes.
//! * [`learning`]: learning curves of a training.
//! * [`gallery`]: sensors and effects in one page; [`gap`]: what the gap workflow found;
//!   `gap_camera`: a camera from recordings alone.

pub mod camera_views;
mod findings;
pub mod fingers;
pub mod gallery;
pub mod gap;
pub(crate) mod gap_camera;
pub mod hand;
pub mod hand_scene;
pub mod held_out;
pub mod learning;
pub mod people;
mod recent_events;
