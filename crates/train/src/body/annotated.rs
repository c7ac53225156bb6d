//! Images with an annotation file, as other data sets are prepared.

use std::path::Path;

use evpose_core::{Micros, Plane};
use evpose_datasets::read_annotations;
use rayon::prelude::*;

use super::frames::{BodyFrame, BodyFrames};
use crate::TrainError;

/// Name of the annotation file, and of the folder of images beside it.
const ANNOTATIONS: &str = "poses.json";
const IMAGES: &str = "images";

/// The images of a directory that holds `poses.json` and `images/`.
pub(super) fn frames(
    directory: &Path,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<BodyFrames, TrainError> {
    let annotations = read_annotations(&directory.join(ANNOTATIONS))?;
    let frame = |(index, annotation): (usize, &evpose_datasets::Annotation)| {
        let path = directory.join(IMAGES).join(&annotation.image);
        let problem = |message: String| TrainError::Config { path: path.clone(), message };
        let image = image::open(&path).map_err(|error| problem(error.to_string()))?.into_luma8();
        let (width, height) = (image.width() as usize, image.height() as usize);
        let image = Plane::from_vec(width, height, image.into_raw())
            .map_err(|error| problem(error.to_string()))?;
        progress(1);
        let t = Micros((annotation.t_s.unwrap_or(0.0) * 1e6).round() as i64);
        Ok(BodyFrame { image, label: annotation.label.clone(), sequence: index as u64, t })
    };
    let frames =
        annotations.par_iter().enumerate().map(frame).collect::<Result<_, TrainError>>()?;
    Ok(BodyFrames { frames })
}
