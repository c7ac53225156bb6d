//! Data sets of bodies as they are distributed, and the annotations that networks are trained on.
//!
//! * [`Annotation`]: an image and the person on it, as one line of JSON for a whole set.
//! * [`LabelledRecording`]: events of a camera with the joints of the person, of any data set;
//!   [`write_eros_frames`] makes images and annotations of it.
//! * [`dhp19`]: movements seen by four event cameras.
//! * [`mat`]: files of MATLAB, as several data sets have them.

mod annotation;
pub mod dhp19;
mod error;
pub mod mat;
mod recording;

pub use annotation::{Annotation, read_annotations, write_annotations};
pub use error::DatasetError;
pub use recording::{
    ErosFrameOptions, ErosStyle, LabelledRecording, TimedBody, TorsoRule, body_label,
    write_eros_frames,
};
