//! Image sizes of annotations.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use evpose_core::SensorSize;
use evpose_datasets::check::LabelTrack;
use glam::Vec2;

/// Usual folders of images beside annotations.
const FOLDERS: [&str; 2] = ["images", "eros"];

pub(super) enum ImageSizes {
    Given(Vec2),
    Beside { annotations: PathBuf, folders: Vec<PathBuf> },
}

impl ImageSizes {
    /// Image sizes of the annotations at `path`.
    pub(super) fn beside(path: &Path, given: Option<SensorSize>) -> Self {
        if let Some(SensorSize { width, height }) = given {
            return Self::Given(Vec2::new(width.into(), height.into()));
        }
        let beside = path.parent().unwrap_or(Path::new(""));
        let folders = FOLDERS.map(|folder| beside.join(folder)).to_vec();
        Self::Beside { annotations: path.to_owned(), folders }
    }

    /// Width and height of a track's images, which are all of the size of the first.
    pub(super) fn image_size(&self, track: &LabelTrack) -> Result<Vec2> {
        let (annotations, folders) = match self {
            // A size that is given holds for all, without a look at any image.
            Self::Given(size) => return Ok(*size),
            Self::Beside { annotations, folders } => (annotations, folders),
        };
        let images = track
            .frames
            .iter()
            .flat_map(|frame| folders.iter().map(move |folder| folder.join(&frame.name)));
        // Images of a track have one size, so the first that is there will do.
        let Some(image) = images.into_iter().find(|image| image.is_file()) else {
            bail!(
                "{}: the images of {} are neither in images/ nor in eros/ beside it, so that their size \
                 is not known: give it, as --image-size 640x480",
                annotations.display(),
                track.name
            );
        };
        let (width, height) = image::image_dimensions(&image)
            .with_context(|| format!("reading the size of {}", image.display()))?;
        Ok(Vec2::new(width as f32, height as f32))
    }
}
