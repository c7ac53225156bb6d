//! A directory of sequences that several machines fill, with digests of the complete ones.
//!
//! Sequence 7 is `0007.evc`, `0007.meta`, `0007.joints.npy`, `0007.toml`, and last of all `0007.sha256`
//! with their digests: while that is not there, the sequence counts as unfinished. When the digests of all
//! sequences are there, the process that notices joins them to `manifest.sha256`, in the order of the
//! sequences: the same bytes from any process, without reading the data again.

mod digest;
mod fault;
mod manifest;
mod shard;
mod verify;

use std::path::{Path, PathBuf};

use evpose_core::{atomic_write, temporary_target};
use evpose_io::HAND_JOINTS_ENDING;

use crate::person::PeopleConfig;
use crate::{EventFormat, SimError, SimulationConfig};
use digest::FileDigest;

pub use fault::{DigestMismatch, MismatchKind};
pub use shard::Shard;
pub use verify::{Verified, verify};

/// File name of the manifest.
pub const MANIFEST: &str = "manifest.sha256";
/// Endings of the files of hands, with the events in the usual format.
pub const HANDS: [&str; 4] = ["evc", "meta", HAND_JOINTS_ENDING, "toml"];
/// Endings of the files of people, with the events in the usual format.
pub const PEOPLE: [&str; 3] = ["raw", "poses.csv", "toml"];
/// Ending of the file of digests of a sequence.
const DIGESTS: &str = "sha256";

/// The directory of the sequences of a run.
#[derive(Debug, Clone)]
pub struct SequenceSet {
    directory: PathBuf,
    sequences: u64,
    /// Endings of the files of a sequence, in the order of the manifest: events, labels, the rest.
    endings: Vec<&'static str>,
}

impl SequenceSet {
    /// A run of `sequences` sequences of hands in `directory`. Nothing is read or written yet.
    pub fn new(directory: impl Into<PathBuf>, sequences: usize) -> Self {
        Self { directory: directory.into(), sequences: sequences as u64, endings: HANDS.to_vec() }
    }

    /// A run of hands in `directory`, with events in the format of `config`.
    ///
    /// # Errors
    /// If the config names no format that can be written.
    pub fn of_hands(
        directory: impl Into<PathBuf>,
        config: &SimulationConfig,
    ) -> Result<Self, SimError> {
        let mut endings = HANDS;
        endings[0] = EventFormat::of_hands(config)?.ending();
        Ok(Self::new(directory, config.sequences).with_endings(endings))
    }

    /// A run of people in `directory`, with events in the format of `config`.
    ///
    /// # Errors
    /// As [`Self::of_hands`].
    pub fn of_people(
        directory: impl Into<PathBuf>,
        config: &PeopleConfig,
    ) -> Result<Self, SimError> {
        let mut endings = PEOPLE;
        endings[0] = EventFormat::of_people(config)?.ending();
        Ok(Self::new(directory, config.sequences).with_endings(endings))
    }

    /// Replaces the endings of the files of a sequence: events, labels, the rest.
    #[must_use]
    pub fn with_endings(self, endings: impl Into<Vec<&'static str>>) -> Self {
        Self { endings: endings.into(), ..self }
    }

    /// Directory that holds the set.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// Number of sequences of the complete set.
    pub fn sequences(&self) -> u64 {
        self.sequences
    }

    /// Path of a sequence, without the endings of its files.
    pub fn stem(&self, sequence: u64) -> PathBuf {
        self.directory.join(name(sequence))
    }

    /// Sequences of `shard` that are not complete.
    pub fn unfinished(&self, shard: Shard) -> Vec<u64> {
        shard
            .sequences_of(self.sequences)
            .filter(|&sequence| self.digests(sequence).is_none())
            .collect()
    }

    /// Whether a file of a sequence of `shard` exists, complete or not.
    pub fn holds_any(&self, shard: Shard) -> bool {
        let mut stems = shard.sequences_of(self.sequences).map(|sequence| self.stem(sequence));
        stems.any(|stem| {
            self.endings.iter().chain([&DIGESTS]).any(|ending| stem.with_extension(ending).exists())
        })
    }

    /// Removes temporary files that killed processes left of the sequences of `shard`, and returns
    /// their number.
    ///
    /// # Errors
    /// If the directory cannot be read or a file not removed.
    pub fn remove_leftovers(&self, shard: Shard) -> Result<usize, SimError> {
        // Before its first run a set has no directory.
        if !self.directory.exists() {
            return Ok(0);
        }
        let mut removed = 0;
        for file in list(&self.directory)? {
            let Some((number, _)) = temporary_target(&file).and_then(|name| name.split_once('.'))
            else {
                continue;
            };
            // Other shards may be writing theirs into the same directory at this moment.
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

    /// Marks a sequence as complete: reads its files once more, from the page cache, and writes
    /// their digests.
    pub fn seal(&self, sequence: u64) -> Result<(), SimError> {
        let mut text = String::new();
        for file in self.files(sequence) {
            text += &FileDigest::compute(&self.directory, &file, &|_| {})?.line();
        }
        let path = self.stem(sequence).with_extension(DIGESTS);
        atomic_write(&path, text.as_bytes())
            .map_err(|source| SimError::file(&path, "write", source))
    }

    /// Text of the digests of a sequence, or none if it is not complete.
    fn digests(&self, sequence: u64) -> Option<String> {
        let text = std::fs::read_to_string(self.stem(sequence).with_extension(DIGESTS)).ok()?;
        let read: Option<Vec<FileDigest>> =
            text.lines().map(|line| FileDigest::parse(line).ok()).collect();
        let read = read?;
        let mut files = self.files(sequence);
        // Sets from before there were joints are complete without them.
        if read.len() < files.len() {
            files.retain(|file| !file.ends_with(HAND_JOINTS_ENDING));
        }
        let names = read.iter().map(|digest| digest.name.as_str());
        let is_complete = names.eq(files.iter().map(String::as_str))
            // A list of digests without its files is that of a set that was partly deleted.
            && files.iter().all(|file| self.directory.join(file).exists());
        is_complete.then(|| read.iter().map(FileDigest::line).collect())
    }

    /// The files of a sequence that readers use.
    fn files(&self, sequence: u64) -> Vec<String> {
        self.endings.iter().map(|ending| format!("{}.{ending}", name(sequence))).collect()
    }
}

fn name(sequence: u64) -> String {
    format!("{sequence:04}")
}

/// Sorted file names of a directory; names that are not UTF-8 are not of a set and left out.
fn list(directory: &Path) -> Result<Vec<String>, SimError> {
    let failed = |source| SimError::file(directory, "read", source);
    let mut names = Vec::new();
    for entry in std::fs::read_dir(directory).map_err(failed)? {
        names.extend(entry.map_err(failed)?.file_name().into_string());
    }
    names.sort();
    Ok(names)
}
