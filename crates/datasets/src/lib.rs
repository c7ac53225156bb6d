//! Data sets of bodies as they are distributed, and the annotations that networks are trained on.
//!
//! * [`Annotation`]: an image and the person on it, as one line of JSON for a whole set.
//! * [`LabelledRecording`]: events of a camera with the joints of the person, of any data set;
//!   [`write_eros_frames`] makes images and annotations of it, [`FrameSet`] of many.
//! * [`split_by_group`]: a set in two, by what belongs together.
//! * [`check`]: labels that are wrong, or look as if they were.
//! * [`dhp19`]: movements seen by four event cameras.
//! * [`h36m`]: clips of videos that were turned into events.
//! * [`mpii`]: photographs of persons, made to look like events.

mod annotation;
pub mod check;
pub mod dhp19;
mod error;
pub mod h36m;
pub mod mpii;
mod open;
mod recording;
mod split;

pub use annotation::{Annotation, read_annotations, write_annotations};
pub use error::DatasetError;
pub use recording::{
    ErosFrameOptions, ErosStyle, FrameSet, LabelledRecording, TimedBody, TorsoRule, body_label,
    write_eros_frames,
};
pub use split::{Split, split_by_group};
