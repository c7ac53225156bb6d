//! Keypoints as COCO's JSON: see [`coco`](crate::coco).
//!
//! An image has a time stamp if it has a field `t_us` or `timestamp_us`. The head is the mean of the
//! labelled ones of nose, eyes and ears.

use std::path::Path;

use crate::coco::{CocoPerson, read_keypoints};
use evpose_core::Micros;

use super::format::{BodyLabelFormat, LabelledImage, first_character, has_ending};
use crate::import::ImportError;
use crate::import::clock::ImageTime;

pub(super) static FORMAT: BodyLabelFormat = BodyLabelFormat {
    name: "coco",
    summary: "COCO's JSON of keypoints",
    detect: |path, start| has_ending(path, "json") && first_character(start) == Some(b'{'),
    read,
};

fn read(path: &Path) -> Result<Vec<LabelledImage>, ImportError> {
    let images = read_keypoints(path)?.into_iter().map(|image| LabelledImage {
        time: match image.t_us {
            Some(t_us) => ImageTime::Stamp(Micros(t_us.round() as i64)),
            None => ImageTime::Name(image.file_name),
        },
        size_px: image.size_px,
        persons: image.persons.iter().map(CocoPerson::joints_px).collect(),
    });
    Ok(images.collect())
}
