//! Bodies: what networks of MoveEnet are trained on and measured by.
//!
//! * [`BodyAugmentation`], [`BodyView`]: images and labels, each time a little different.
//! * [`BodyGrid`]: what the maps of a network should be for a label.
//! * [`BodyBatch`]: the same for many labels, and as tensors.
//! * [`BodyAccuracy`]: how many joints are found.

mod accuracy;
mod augmentation;
mod batch;
mod targets;

pub use accuracy::{BodyAccuracy, BodyAccuracyConfig, BodyMeasure};
pub use augmentation::{BodyAugmentation, BodyView, Interpolation, resize_grey};
pub use batch::BodyBatch;
pub use targets::{BodyGrid, BodyTargetSlices};
