//! MPII into images of persons.

use evpose_containers::mat::MatFile;

use super::release::Release;
use crate::DatasetError;
use crate::stills::{self, Converted, PersonFault, Photograph, SkipReason, StillOptions, StillSet};

/// Converts MPII's photographs for training; `options.annotations` is
/// `mpii_human_pose_v1_u12_1.mat`.
///
/// # Source
/// `export_to_eros.py` and `export_to_movenet.py` of hpe-core, one behind the other: the look is
/// made of the whole photograph.
///
/// # Errors
/// As [`stills`](crate::stills) has them.
pub fn convert(
    options: &StillOptions,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Converted, DatasetError> {
    let read = |path: &std::path::Path, bytes: &[u8]| {
        let file = MatFile::parse(bytes).map_err(DatasetError::mat(path))?;
        let release = Release::read(path, &file)?;
        let photographs = release.photographs.into_iter().map(|photograph| Photograph {
            index: photograph.index,
            name: photograph.name,
            persons: photograph
                .persons
                .into_iter()
                .map(|person| match person {
                    Ok(person) => Ok(person.to_still(options.parity)),
                    Err(error) => Err(PersonFault {
                        reason: SkipReason::BadField,
                        detail: Some(error.to_string()),
                    }),
                })
                .collect(),
        });
        Ok(StillSet {
            name: "mpii",
            photographs: photographs.collect(),
            not_for_training: release.not_for_training,
        })
    };
    stills::convert(options, read, progress)
}
