//! Recordings of hands with joints or parameters as labels.
//!
//! * [`HAND_LABEL_FORMATS`]: the formats of labels, one file each; [`read_hand_labels`] reads any.
//! * [`HandFitter`]: parameters of a hand from its labelled joints.
//! * [`import_hand`]: a recording and its labels as sequences in the view of a network.

mod fit;
mod format;
mod joints;
mod least_squares;
mod parameters;
mod registry;
mod sequence;
mod starts;
mod target;
mod track;

pub use fit::{FitOptions, FittedHand, HandFitter};
pub use format::{HandJoints, HandLabelFormat, HandLabels, LabelChoice, LabelledHand};
pub use registry::{HAND_LABEL_FORMATS, read_hand_labels};
pub use sequence::{HandOptions, HandReport, import_hand};
