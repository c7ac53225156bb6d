//! Errors of reading folders of others: MakeHuman's files, and motion capture.

use std::io;
use std::path::{Path, PathBuf};

use evpose_core::without_bom;

/// Error of reading a folder of MakeHuman's files or of motion capture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FolderError {
    /// The operating system refused access, or a compressed file is damaged.
    #[error("{}: cannot read", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// Cause of the failure.
        source: io::Error,
    },
    /// A line is malformed.
    #[error("{}: line {line}: {reason}", path.display())]
    Line {
        /// File that the line is in.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// Defect of the line.
        reason: String,
    },
    /// Content that is needed is missing, or does not fit the rest.
    #[error("{}: {reason}", path.display())]
    Content {
        /// The file or folder.
        path: PathBuf,
        /// Defect.
        reason: String,
    },
}

impl FolderError {
    pub(crate) fn content(path: &Path, reason: impl Into<String>) -> Self {
        Self::Content { path: path.to_owned(), reason: reason.into() }
    }

    pub(crate) fn line(path: &Path, index: usize, reason: impl Into<String>) -> Self {
        Self::Line { path: path.to_owned(), line: index + 1, reason: reason.into() }
    }
}

/// The text of a file.
pub(crate) fn read_text(path: &Path) -> Result<String, FolderError> {
    let text = std::fs::read_to_string(path)
        .map_err(|source| FolderError::File { path: path.to_owned(), source })?;
    Ok(without_bom(&text).to_owned())
}

/// Paths in a folder, in the order of their names.
pub(crate) fn sorted_paths(folder: &Path) -> Result<Vec<PathBuf>, FolderError> {
    let file = |source| FolderError::File { path: folder.to_owned(), source };
    let entries = std::fs::read_dir(folder).map_err(file)?;
    let paths = entries.map(|entry| entry.map(|entry| entry.path()));
    let mut paths = paths.collect::<Result<Vec<_>, _>>().map_err(file)?;
    paths.sort();
    Ok(paths)
}
