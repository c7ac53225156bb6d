//! MPII Human Pose, as networks for events are first trained on.
//!
//! * [`convert()`]: photographs and annotations into images of persons and one annotation file.
//! * [`read_joints`]: joints of all persons, without the images.
//! * [`MPII_INDEX`]: which of its points our joints are.
//!
//! # Source
//! Andriluka, Pishchulin, Gehler, Schiele: *2D Human Pose Estimation: New Benchmark and State of
//! the Art Analysis*, CVPR 2014; the conversion is that of Goyal, Di Pietro, Carissimi, Glover,
//! Bartolozzi: *MoveEnet*, CVPRW 2023.

mod convert;
mod joints;
mod person;
mod release;

pub use convert::convert;
pub use joints::{MpiiImage, read_joints};
pub use person::MPII_INDEX;
