//! Folders of ROS 2 bags: `metadata.yaml` names the files, in the order of their recording.

use std::fs;
use std::path::{Path, PathBuf};

use crate::{Input, IoError};

/// Whether a folder is a bag.
pub(crate) fn is_bag(folder: &Path) -> bool {
    folder.join("metadata.yaml").is_file()
}

/// The first file of a bag, under the name of its folder.
///
/// # Errors
/// If the folder cannot be read, or none of the files is there.
pub(crate) fn first(folder: &Path) -> Result<Input, IoError> {
    let first = files(folder)?.into_iter().next().ok_or_else(|| IoError::Stream {
        path: folder.to_owned(),
        reason: "none of the files that its metadata.yaml names is there".to_owned(),
    })?;
    Ok(Input { path: folder.to_owned(), ..Input::file(first)? })
}

/// The files behind the first of a bag that is a folder.
pub(super) fn others(path: &Path) -> Result<Vec<Input>, IoError> {
    if !path.is_dir() {
        return Ok(Vec::new());
    }
    files(path)?.into_iter().skip(1).map(Input::file).collect()
}

/// Refuses databases with messages that SQLite has not yet put into them: a recorder was killed.
pub(super) fn check_merged(path: &Path) -> Result<(), IoError> {
    let databases = if path.is_dir() { files(path)? } else { vec![path.to_owned()] };
    for database in databases {
        let mut name = database.clone().into_os_string();
        name.push("-wal");
        if fs::metadata(&name).is_ok_and(|log| log.len() > 0) {
            let reason = format!(
                "its last messages are in the file {} beside it: put them into it by \
                 sqlite3 FILE.db3 'PRAGMA wal_checkpoint'",
                name.display()
            );
            return Err(IoError::Stream { path: database, reason });
        }
    }
    Ok(())
}

fn files(folder: &Path) -> Result<Vec<PathBuf>, IoError> {
    let failed = |error| IoError::file(folder, "read", error);
    let metadata = fs::read_to_string(folder.join("metadata.yaml")).map_err(failed)?;
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        // Whole names: `bag_1.db3` is a part of `bag_1.db3.zstd`.
        let place = metadata.split_whitespace().position(|word| {
            let word = word.trim_matches(['"', '\'']);
            word == name || word.strip_suffix(&name).is_some_and(|before| before.ends_with('/'))
        });
        files.extend(place.map(|place| (place, path)));
    }
    files.sort();
    Ok(files.into_iter().map(|(_, path)| path).collect())
}
