//! Directories of recordings: the files in them, by name.

use std::path::Path;

use crate::TrainError;

/// Names of the files of a directory, in their order: sequences are numbered by it.
///
/// # Errors
/// If it cannot be read.
pub(crate) fn file_names(directory: &Path) -> Result<Vec<String>, TrainError> {
    let failed = |source| TrainError::Io { path: directory.to_owned(), source };
    let mut names = Vec::new();
    for entry in std::fs::read_dir(directory).map_err(failed)? {
        names.extend(entry.map_err(failed)?.file_name().into_string());
    }
    names.sort();
    Ok(names)
}

/// The file of events of a format that can be written, whose name is `stem` and an ending.
pub(crate) fn events_of<'a>(names: &'a [String], stem: &str) -> Option<&'a String> {
    names.iter().find(|name| {
        let ending = name.strip_prefix(stem).and_then(|rest| rest.strip_prefix('.'));
        // With a further dot, as in `0000.poses.csv`, it is another file than the recording.
        ending.is_some_and(|ending| {
            !ending.contains('.') && evpose_io::format_for(Path::new(name)).is_ok()
        })
    })
}
