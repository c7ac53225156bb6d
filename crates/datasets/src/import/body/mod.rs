//! Recordings of people with joints labelled in 2D.
//!
//! * [`BODY_LABEL_FORMATS`]: the formats of labels, one file each; [`read_body_labels`] reads any.
//! * [`import_body`]: a recording and its labels as the sequences that networks are trained on.

mod coco;
mod csv;
mod format;
mod mpii_json;
mod mpii_release;
mod poses;
mod registry;
mod sequence;

pub use format::{BodyLabelFormat, LabelledImage};
pub use registry::{BODY_LABEL_FORMATS, read_body_labels};
pub use sequence::{BodyOptions, BodyReport, import_body};
