//! A directory of sequences that several machines fill, and that tells what is whole in it.
//!
//! Sequence 7 is `0007.evc`, `0007.meta`, `0007.toml`, and last of all `0007.sha256` with their
//! digests: while that is not there, the sequence counts as unfinished. When the digests of all
//! sequences are there, whoever sees it joins them to `manifest.sha256`, in the order of the
//! sequences; so it is the same bytes whoever writes it, and writing it needs no one's data again.

mod digest;
mod manifest;
mod shard;
mod verify;

use std::path::{Path, PathBuf};

use evpose_core::{atomic_write, temporary_target};

use crate::SimError;
use digest::FileDigest;

pub use shard::Shard;
pub use verify::{Fault, FaultKind, Verified, verify};

/// Name of the manifest.
pub const MANIFEST: &str = "manifest.sha256";
/// Endings of the files of a sequence, in the order of the manifest: events, labels, the rest.
pub type Endings = [&'static str; 3];
/// The files of hands.
pub const HANDS: Endings = ["evc", "meta", "toml"];
/// The files of people.
pub const PEOPLE: Endings = ["raw", "poses.csv", "toml"];
/// Ending of the digests of a sequence.
const DIGESTS: &str = "sha256";

/// The directory of the sequences of a run.
#[derive(Debug, Clone)]
pub struct SequenceSet {
    directory: PathBuf,
    sequences: u64,
    endings: Endings,
}

impl SequenceSet {
    /// The directory of a run of so many sequences of hands. Nothing is read or written yet.
    pub fn new(directory: impl Into<PathBuf>, sequences: usize) -> Self {
        Self { directory: directory.into(), sequences: sequences as u64, endings: HANDS }
    }

    /// The same for sequences of other files.
    #[must_use]
    pub fn holding(self, endings: Endings) -> Self {
        Self { endings, ..self }
    }

    /// The directory.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// How many sequences there will be.
    pub fn sequences(&self) -> u64 {
        self.sequences
    }

    /// Path of a sequence, without the endings of its files.
    pub fn stem(&self, sequence: u64) -> PathBuf {
        self.directory.join(name(sequence))
    }

    /// The sequences of `shard` that are not whole.
    pub fn unfinished(&self, shard: Shard) -> Vec<u64> {
        shard.of(self.sequences).filter(|&sequence| self.digests(sequence).is_none()).collect()
    }

    /// Whether any file of a sequence of `shard` is there, whole or not.
    pub fn holds_any(&self, shard: Shard) -> bool {
        let mut stems = shard.of(self.sequences).map(|sequence| self.stem(sequence));
        stems.any(|stem| {
            self.endings.iter().chain([&DIGESTS]).any(|ending| stem.with_extension(ending).exists())
        })
    }

    /// Removes what killed processes left of the sequences of `shard`, and says how many files that
    /// were. Files that others are writing stay.
    ///
    /// # Errors
    /// If the directory cannot be read or a file not removed.
    pub fn remove_leftovers(&self, shard: Shard) -> Result<usize, SimError> {
        if !self.directory.exists() {
            return Ok(0);
        }
        let mut removed = 0;
        for file in list(&self.directory)? {
            let Some((number, _)) = temporary_target(&file).and_then(|name| name.split_once('.'))
            else {
                continue;
            };
            let ours = number.parse().is_ok_and(|sequence: u64| {
                sequence < self.sequences && shard.owns(sequence) && name(sequence) == number
            });
            if ours {
                let path = self.directory.join(file);
                std::fs::remove_file(&path)
                    .map_err(|source| SimError::file(&path, "remove", source))?;
                removed += 1;
            }
        }
        Ok(removed)
    }

    /// Declares a sequence whole: reads its files once more, out of the page cache, and writes their
    /// digests.
    pub(crate) fn seal(&self, sequence: u64) -> Result<(), SimError> {
        let mut text = String::new();
        for file in self.files(sequence) {
            text += &FileDigest::of(&self.directory, &file, &|_| {})?.line();
        }
        let path = self.stem(sequence).with_extension(DIGESTS);
        atomic_write(&path, text.as_bytes())
            .map_err(|source| SimError::file(&path, "write", source))
    }

    /// The digests of a sequence as they stand in its file, or none if it is not whole.
    fn digests(&self, sequence: u64) -> Option<String> {
        let text = std::fs::read_to_string(self.stem(sequence).with_extension(DIGESTS)).ok()?;
        let read: Option<Vec<FileDigest>> =
            text.lines().map(|line| FileDigest::parse(line).ok()).collect();
        let read = read?;
        let names = read.iter().map(|digest| digest.name.as_str());
        let files = self.files(sequence);
        let whole = names.eq(files.iter().map(String::as_str))
            && files.iter().all(|file| self.directory.join(file).exists());
        whole.then(|| read.iter().map(FileDigest::line).collect())
    }

    /// The files of a sequence that readers use.
    fn files(&self, sequence: u64) -> [String; 3] {
        self.endings.map(|ending| format!("{}.{ending}", name(sequence)))
    }
}

fn name(sequence: u64) -> String {
    format!("{sequence:04}")
}

/// Names of the files of a directory, sorted; those that are not text are none of ours.
fn list(directory: &Path) -> Result<Vec<String>, SimError> {
    let failed = |source| SimError::file(directory, "read", source);
    let mut names = Vec::new();
    for entry in std::fs::read_dir(directory).map_err(failed)? {
        names.extend(entry.map_err(failed)?.file_name().into_string());
    }
    names.sort();
    Ok(names)
}
