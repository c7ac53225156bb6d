//! MPII Human Pose, as networks for events are first trained on.
//!
//! * [`convert()`]: photographs and annotations into images of persons, like EROS or grey
//!   ([`MpiiStyle`]), and one annotation file.
//! * [`Converted`]: what was converted, and what was skipped and why ([`SkipReason`]).
//! * [`read_joints`]: joints of all persons, without the images.
//! * [`photograph_of_crop`]: from which photograph an image is, to split a set by photographs.
//!
//! # Source
//! Andriluka, Pishchulin, Gehler, Schiele: *2D Human Pose Estimation: New Benchmark and State of
//! the Art Analysis*, CVPR 2014; the conversion is that of Goyal, Di Pietro, Carissimi, Glover,
//! Bartolozzi: *MoveEnet*, CVPRW 2023.

mod convert;
mod image_file;
mod joints;
mod label;
mod options;
mod person;
mod release;
mod report;
mod window;

pub use convert::convert;
pub use joints::{MpiiImage, read_joints};
pub use options::{CropFormat, MpiiOptions, MpiiStyle};
pub use report::{Converted, SkipReason, Skipped};

/// The photograph that an image of a person is from: its name without the person's number and
/// ending.
pub fn photograph_of_crop(image: &str) -> &str {
    image.rsplit_once('_').map_or(image, |(photograph, _)| photograph)
}
