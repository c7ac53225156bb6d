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
/// If the folder cannot be read, or a file of it is missing.
pub(crate) fn first(folder: &Path) -> Result<Input, IoError> {
    let first = files(folder)?.into_iter().next().ok_or_else(|| IoError::Stream {
        path: folder.to_owned(),
        reason: "its metadata.yaml names no files below relative_file_paths".to_owned(),
    })?;
    Ok(Input { path: folder.to_owned(), ..Input::file(first)? })
}

/// Refuses a database with messages that SQLite has not yet put into them: a recorder was killed.
pub(super) fn check_merged(database: &Path) -> Result<(), IoError> {
    let mut name = database.to_owned().into_os_string();
    name.push("-wal");
    if fs::metadata(&name).is_ok_and(|log| log.len() > 0) {
        let reason = format!(
            "its last messages are in the file {} beside it: put them into it by \
             sqlite3 FILE.db3 'PRAGMA wal_checkpoint'",
            name.display()
        );
        return Err(IoError::Stream { path: database.to_owned(), reason });
    }
    Ok(())
}

/// The files that the metadata list, below `relative_file_paths`; all have to be there.
pub(super) fn files(folder: &Path) -> Result<Vec<PathBuf>, IoError> {
    let metadata = folder.join("metadata.yaml");
    let text = fs::read_to_string(&metadata).map_err(|e| IoError::file(&metadata, "read", e))?;
    let list = text.lines().skip_while(|line| line.trim() != "relative_file_paths:").skip(1);
    let entries = list.map_while(|line| line.trim().strip_prefix("- "));
    let mut files = Vec::new();
    for entry in entries {
        // Older recorders name the folder, too.
        let name = Path::new(entry.trim().trim_matches(['"', '\''])).file_name();
        let path = folder.join(name.unwrap_or_default());
        if !path.is_file() {
            let reason = format!("its metadata.yaml names {entry}, which is not in the folder");
            return Err(IoError::Stream { path: folder.to_owned(), reason });
        }
        files.push(path);
    }
    Ok(files)
}
