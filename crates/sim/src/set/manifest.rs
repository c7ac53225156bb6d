//! The digests of all sequences in one file, which `sha256sum -c` reads too.

use std::path::{Path, PathBuf};

use evpose_core::atomic_write;

use super::digest::FileDigest;
use super::{MANIFEST, SequenceSet, Shard};
use crate::SimError;

impl SequenceSet {
    /// Where the manifest is, or will be.
    pub fn manifest(&self) -> PathBuf {
        self.directory.join(MANIFEST)
    }

    /// Writes the manifest if every sequence of the set is whole, and says whether it is there.
    ///
    /// Everyone who finishes a sequence calls this *after* its digests are there, so the last one
    /// finds all of them; two who both do write the same bytes.
    ///
    /// # Errors
    /// If the manifest cannot be written.
    pub fn write_manifest(&self) -> Result<bool, SimError> {
        let digests = Shard::WHOLE.of(self.sequences).map(|sequence| self.digests(sequence));
        let Some(text) = digests.collect::<Option<String>>() else { return Ok(false) };
        let path = self.manifest();
        // A set that is whole stays as it is, down to the times of its files.
        if std::fs::read(&path).is_ok_and(|bytes| bytes == text.as_bytes()) {
            return Ok(true);
        }
        atomic_write(&path, text.as_bytes())
            .map_err(|source| SimError::file(&path, "write", source))?;
        Ok(true)
    }
}

/// The lines of a list of digests.
pub(super) fn read(path: &Path) -> Result<Vec<FileDigest>, SimError> {
    let text =
        std::fs::read_to_string(path).map_err(|source| SimError::file(path, "read", source))?;
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
