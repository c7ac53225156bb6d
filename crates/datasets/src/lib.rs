//! Data sets of bodies as they are distributed, and the annotations that networks are trained on.
//!
//! * [`Annotation`]: an image and the person on it, as one line of JSON for a whole set.
//! * [`mat`]: files of MATLAB, as several data sets have them.

mod annotation;
mod error;
pub mod mat;

pub use annotation::{Annotation, read_annotations, write_annotations};
pub use error::DatasetError;
