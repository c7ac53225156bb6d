//! Bodies: what networks of MoveEnet are trained on and measured by.
//!
//! * [`BodyGrid`]: what the maps of a network should be for a label.
//! * [`BodyBatch`]: the same for many labels, and as tensors.

mod batch;
mod targets;

pub use batch::BodyBatch;
pub use targets::{BodyGrid, BodyTargetSlices};
