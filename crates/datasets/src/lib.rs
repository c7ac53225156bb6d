//! Data sets of bodies as they are distributed, and the annotations that networks are trained on.
//!
//! * [`Annotation`]: an image and the person on it, as one line of JSON for a whole set.
//! * [`split_by_group`]: a set in two, by what belongs together.
//! * [`check`]: labels that are wrong, or look as if they were.
//! * [`mpii`]: photographs of persons, made to look like events.
//! * [`mat`]: files of MATLAB, as several data sets have them.

mod annotation;
pub mod check;
mod error;
pub mod mat;
pub mod mpii;
mod split;

pub use annotation::{Annotation, read_annotations, write_annotations};
pub use error::DatasetError;
pub use split::{Split, split_by_group};
