//! Keypoints as COCO's JSON has them, beside their photographs.
//!
//! * [`read_keypoints`]: the persons of every image of a file.
//! * [`convert()`]: photographs and a file into images of persons and one annotation file.
//! * [`keypoint_by_name`]: keypoints by COCO's names or this project's.
//!
//! # Source
//! <https://cocodataset.org/#format-data>, keypoint detection; Lin et al.: *Microsoft COCO: Common
//! Objects in Context*, ECCV 2014.

mod convert;
mod file;
mod keypoint;

pub use convert::convert;
pub use file::{CocoImage, CocoPerson, read_keypoints};
pub use keypoint::{NamedKeypoint, keypoint_by_name};
