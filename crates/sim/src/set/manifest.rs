//! The digests of all sequences in one file, which `sha256sum -c` reads too.

use std::path::{Path, PathBuf};

use evpose_core::atomic_write;

use super::digest::FileDigest;
use super::{MANIFEST, SequenceSet, Shard};
use crate::SimError;

impl SequenceSet {
    /// Path of the manifest.
    pub fn manifest(&self) -> PathBuf {
        self.directory.join(MANIFEST)
    }

    /// Writes the manifest if every sequence of the set is complete; returns whether it exists.
    ///
    /// Each process calls this *after* it has written the digests of a sequence, so the last one
    /// has all of them; two concurrent writers write the same bytes.
    ///
    /// # Errors
    /// If the manifest cannot be written.
    pub fn write_manifest(&self) -> Result<bool, SimError> {
        let digests =
            Shard::WHOLE.sequences_of(self.sequences).map(|sequence| self.digests(sequence));
        let Some(text) = digests.collect::<Option<String>>() else { return Ok(false) };
        let path = self.manifest();
        // A complete set is not rewritten, so that its modification time stays.
        if std::fs::read(&path).is_ok_and(|bytes| bytes == text.as_bytes()) {
            return Ok(true);
        }
        atomic_write(&path, text.as_bytes())
            .map_err(|source| SimError::file(&path, "write", source))?;
        Ok(true)
    }
}

/// Reads a list of digests, which ends with a line feed unless its end is lost.
pub(super) fn read(path: &Path) -> Result<Vec<FileDigest>, SimError> {
    let text =
        std::fs::read_to_string(path).map_err(|source| SimError::file(path, "read", source))?;
    // A name that is cut short could be that of another file.
    if !text.is_empty() && !text.ends_with('\n') {
        let (path, line) = (path.to_owned(), text.lines().count());
        return Err(SimError::Manifest { path, line, reason: "cut off: no line feed at its end" });
    }
    let lines = text.lines().enumerate();
    let parsed = lines.map(|(number, line)| {
        FileDigest::parse(line).map_err(|reason| SimError::Manifest {
            path: path.to_owned(),
            line: number + 1,
            reason,
        })
    });
    parsed.collect()
}
