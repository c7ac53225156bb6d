//! Joints as MPII publishes them: the structure `RELEASE` of a MAT-file.
//!
//! Images are those with a flag in `img_train`; others have no published joints.

use std::path::Path;

use crate::mpii::read_joints;

use super::format::{BodyLabelFormat, LabelledImage, has_ending};
use crate::import::ImportError;
use crate::import::clock::ImageTime;

pub(super) static FORMAT: BodyLabelFormat = BodyLabelFormat {
    name: "mpii",
    summary: "MPII's MAT-file",
    detect: |path, _| has_ending(path, "mat"),
    read,
};

fn read(path: &Path) -> Result<Vec<LabelledImage>, ImportError> {
    let images = read_joints(path)?.into_iter().map(|image| LabelledImage {
        time: ImageTime::Name(image.name),
        size_px: None,
        persons: image.persons,
    });
    Ok(images.collect())
}
