//! Listing of the clips in a folder.

use std::path::{Path, PathBuf};

use super::clip_name::SERIALS;
use super::{ClipName, FRONT_CAMERAS, SUBJECTS};
use crate::DatasetError;

/// The published clips in a folder, in the order of their names: folders with events and labels.
/// Other entries are passed over.
///
/// # Errors
/// If the folder cannot be read.
pub fn published_clips(folder: &Path) -> Result<Vec<ClipName>, DatasetError> {
    let mut clips = Vec::new();
    for path in entries(folder)? {
        let name = path.file_name().and_then(|name| name.to_str());
        let Some(name) = name.and_then(|name| name.parse::<ClipName>().ok()) else { continue };
        let parts = [ClipName::events_folder(&path), path.join(name.labels_channel())];
        if parts.iter().all(|part| part.is_dir()) {
            clips.push(name);
        }
    }
    clips.sort();
    Ok(clips)
}

/// The clips of the front cameras in the folder of the original data set, in the order of their
/// names: files of poses such as `S9/Poses_D2_Positions/Walking 1.55011271.cdf`. `_ALL`, which is
/// all of them, and persons that are not there are passed over.
///
/// # Errors
/// If a folder cannot be read.
pub fn original_clips(root: &Path) -> Result<Vec<ClipName>, DatasetError> {
    let mut clips = Vec::new();
    for subject in SUBJECTS {
        let folder = root.join(format!("S{subject}/Poses_D2_Positions"));
        if !folder.is_dir() {
            continue;
        }
        for path in entries(&folder)? {
            let name = path.file_name().and_then(|name| name.to_str());
            let parts = name.and_then(|name| name.strip_suffix(".cdf")?.split_once('.'));
            let Some((action, serial)) = parts else { continue };
            // Files of the original set name cameras by their serials.
            let camera =
                SERIALS.iter().find(|(_, known)| *known == serial).map(|(camera, _)| *camera);
            let camera = camera.filter(|camera| FRONT_CAMERAS.contains(camera));
            let clip = camera.and_then(|camera| ClipName::new(camera, subject, action));
            clips.extend(clip.filter(|_| !action.starts_with('_')));
        }
    }
    clips.sort();
    Ok(clips)
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>, DatasetError> {
    let failed = |source| DatasetError::Io { path: folder.to_owned(), action: "list it", source };
    let entries = std::fs::read_dir(folder).map_err(failed)?;
    entries.map(|entry| entry.map(|entry| entry.path()).map_err(failed)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clips_of_the_original_are_those_of_the_front_cameras() {
        let root = tempfile::tempdir().unwrap();
        for (subject, file) in [
            (9, "Walking 1.55011271.cdf"),
            (9, "Walking 1.54138969.cdf"),
            (9, "Walking.60457274.cdf"),
            (9, "_ALL.55011271.cdf"),
            (1, "Eating.55011271.cdf"),
            (1, "Eating.55011271.mp4"),
        ] {
            let folder = root.path().join(format!("S{subject}/Poses_D2_Positions"));
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(folder.join(file), "").unwrap();
        }
        let clips = original_clips(root.path()).unwrap();
        let names: Vec<String> = clips.iter().map(ToString::to_string).collect();
        assert_eq!(names, ["cam2_S1_Eating", "cam2_S9_Walking_1", "cam4_S9_Walking"]);
        assert!(clips.iter().all(|clip| clip.poses(root.path()).is_file()));
        assert!(published_clips(root.path()).unwrap().is_empty());
        assert!(published_clips(&root.path().join("none")).is_err());
    }
}
