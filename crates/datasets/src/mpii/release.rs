//! The annotations of MPII: photographs and the persons on them.

use std::path::Path;

use evpose_containers::mat::{MatError, MatFile, MatValue};

use super::person::Person;
use crate::DatasetError;

/// A photograph for training.
#[derive(Debug)]
pub(super) struct MpiiPhotograph {
    /// Index of the photograph in the release, from 0.
    pub(super) index: usize,
    pub(super) name: String,
    /// The persons on it, or what is wrong with one of them.
    pub(super) persons: Vec<Result<Person, MatError>>,
}

/// All annotations.
#[derive(Debug)]
pub(super) struct Release {
    /// MpiiPhotographs for training.
    pub(super) photographs: Vec<MpiiPhotograph>,
    /// How many others there are: their joints are not published.
    pub(super) not_for_training: usize,
}

impl Release {
    /// Reads the variable `RELEASE` of the MAT-file at `path`.
    pub(super) fn read(path: &Path, file: &MatFile) -> Result<Self, DatasetError> {
        let failed = |source| DatasetError::Mat { path: path.to_owned(), source };
        let release = file.variable("RELEASE").map_err(failed)?;
        let images = release.field("annolist").map_err(failed)?;
        let is_train = release.field("img_train").map_err(failed)?;
        let flags = is_train.values().map_err(failed)?;
        if flags.len() != images.len() {
            let reason = format!("{} flags for {} images", flags.len(), images.len());
            return Err(DatasetError::malformed(path, is_train.path(), reason));
        }
        let mut photographs = Vec::new();
        for (index, image) in images.elements().map_err(failed)?.enumerate() {
            // Joints of the others are not published.
            if flags[index] == 1.0 {
                photographs.push(photograph(index, image).map_err(failed)?);
            }
        }
        let not_for_training = flags.len() - photographs.len();
        Ok(Self { photographs, not_for_training })
    }
}

fn photograph(index: usize, image: MatValue<'_>) -> Result<MpiiPhotograph, MatError> {
    let name = image.field("image")?.field("name")?.text()?;
    let persons = match image.filled_field("annorect")? {
        Some(rects) => rects.elements()?.map(Person::read).collect(),
        None => Vec::new(),
    };
    Ok(MpiiPhotograph { index, name, persons })
}
