//! Training checkpoints that are whole or absent.
//!
//! A checkpoint is three files: weights, optimiser state and learning-rate schedule. Each is
//! written under a temporary name and renamed, and a checkpoint counts only once all three are
//! there, so a run killed at any instant resumes from the newest complete one. Each ends with its SHA-256, so that
//! a damaged one is passed over.

use std::fs;
use std::path::{Path, PathBuf};

use burn::tensor::Bytes;
use burn_pack::{Reader, Writer};
use burn_train::checkpoint::{Checkpoint, Checkpointer, CheckpointerError};
use evpose_nn::NnError;
use evpose_nn::weights::{read_checked, with_digest};

use crate::TrainError;

/// The parts of a checkpoint, in the order Burn hands them over.
const PARTS: [&str; 3] = ["model", "optimizer", "schedule"];

/// Writes one part of each checkpoint atomically.
#[derive(Debug, Clone)]
pub(crate) struct AtomicCheckpointer {
    directory: PathBuf,
    part: &'static str,
}

impl AtomicCheckpointer {
    /// One checkpointer for each part, storing below `directory`.
    pub(crate) fn parts(directory: &Path) -> [Self; 3] {
        PARTS.map(|part| Self { directory: directory.to_path_buf(), part })
    }

    fn path(&self, interval: usize) -> PathBuf {
        part_path(&self.directory, self.part, interval)
    }
}

impl<R: Checkpoint> Checkpointer<R> for AtomicCheckpointer {
    fn save(&self, interval: usize, record: R) -> Result<(), CheckpointerError> {
        let bytes = record.checkpoint_into_bytes().map_err(CheckpointerError::Record)?;
        let bytes = in_order(bytes).map_err(|error| CheckpointerError::Record(error.into()))?;
        evpose_core::atomic_write(self.path(interval), &with_digest(&bytes))
            .map_err(CheckpointerError::IOError)
    }

    fn delete(&self, interval: usize) -> Result<(), CheckpointerError> {
        match fs::remove_file(self.path(interval)) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(CheckpointerError::IOError(error))
            }
            _ => Ok(()),
        }
    }

    fn restore(&self, interval: usize) -> Result<R, CheckpointerError> {
        let bytes = read_checked(&self.path(interval))
            .map_err(|error| CheckpointerError::Unknown(error.to_string()))?;
        R::checkpoint_from_bytes(bytes).map_err(CheckpointerError::Record)
    }
}

/// The same file with its tensors in the order of their names: Burn writes those of the optimiser
/// in the order of a hash map, another in every run.
fn in_order(bytes: Bytes) -> Result<Bytes, burn_pack::Error> {
    let reader = Reader::from_bytes(bytes)?;
    let (metadata, scalars) = (reader.metadata().clone(), reader.scalars().clone());
    let mut tensors = reader.into_tensors()?;
    tensors.sort_by(|a, b| a.name.cmp(&b.name));
    let writer = metadata
        .iter()
        .fold(Writer::new(tensors), |writer, (key, value)| writer.with_metadata(key, value));
    scalars
        .into_iter()
        .fold(writer, |writer, (key, value)| writer.with_scalar(&key, value))
        .into_bytes()
}

fn part_path(directory: &Path, part: &str, interval: usize) -> PathBuf {
    directory.join(format!("{part}-{interval}.bpk"))
}

/// Weights of the checkpoint written after validation interval `interval`.
pub(crate) fn weights_path(directory: &Path, interval: usize) -> PathBuf {
    part_path(directory, PARTS[0], interval)
}

/// The newest complete checkpoint below `directory`.
///
/// # Errors
/// If the directory exists but cannot be read.
pub fn newest_checkpoint(directory: &Path) -> Result<Option<usize>, TrainError> {
    Ok(complete_checkpoints(directory)?.first().copied())
}

/// The newest complete and undamaged checkpoint below `directory`, with the faults of the newer ones.
///
/// # Errors
/// If the directory exists but cannot be read; if all checkpoints are damaged, the damage of the newest.
pub(crate) fn intact_checkpoint(
    directory: &Path,
) -> Result<(Option<usize>, Vec<NnError>), TrainError> {
    let mut damage = Vec::new();
    for interval in complete_checkpoints(directory)? {
        let mut parts = PARTS.iter().map(|part| part_path(directory, part, interval));
        match parts.try_for_each(|path| read_checked(&path).map(drop)) {
            Ok(()) => return Ok((Some(interval), damage)),
            Err(error @ NnError::Damaged { .. }) => damage.push(error),
            // It may be intact: what cannot be read now is not to be trained over.
            Err(error) => return Err(error.into()),
        }
    }
    damage.into_iter().next().map_or(Ok((None, Vec::new())), |newest| Err(newest.into()))
}

/// The complete checkpoints, the newest first.
fn complete_checkpoints(directory: &Path) -> Result<Vec<usize>, TrainError> {
    if !directory.exists() {
        return Ok(Vec::new());
    }
    let listing = fs::read_dir(directory)
        .map_err(|source| TrainError::Io { path: directory.to_path_buf(), source })?;
    let mut complete: Vec<usize> = listing
        .filter_map(|entry| {
            let name = entry.ok()?.file_name().into_string().ok()?;
            name.strip_prefix("model-")?.strip_suffix(".bpk")?.parse().ok()
        })
        // A crash may have left some parts of one, from which no run can be resumed.
        .filter(|&interval| PARTS.iter().all(|part| part_path(directory, part, interval).exists()))
        .collect();
    complete.sort_unstable_by(|a, b| b.cmp(a));
    Ok(complete)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_incomplete_checkpoint_does_not_count() {
        let directory = tempfile::tempdir().unwrap();
        let touch = |part, i| fs::write(part_path(directory.path(), part, i), b"x").unwrap();
        assert_eq!(newest_checkpoint(directory.path()).unwrap(), None);
        PARTS.iter().for_each(|part| touch(part, 3));
        touch(PARTS[0], 4);
        touch(PARTS[1], 4);
        assert_eq!(newest_checkpoint(directory.path()).unwrap(), Some(3));
        touch(PARTS[2], 4);
        assert_eq!(newest_checkpoint(directory.path()).unwrap(), Some(4));
    }

    #[test]
    fn a_damaged_checkpoint_is_passed_over_and_if_all_are_the_newest_is_named() {
        let directory = tempfile::tempdir().unwrap();
        let path = |part, interval| part_path(directory.path(), part, interval);
        for (part, interval) in [(0, 3), (1, 3), (2, 3), (0, 4), (1, 4), (2, 4)] {
            fs::write(path(PARTS[part], interval), with_digest(b"record")).unwrap();
        }
        let intact = || intact_checkpoint(directory.path());
        assert!(matches!(intact().unwrap(), (Some(4), damage) if damage.is_empty()));
        // Half of the optimiser.
        fs::write(path(PARTS[1], 4), b"rec").unwrap();
        let (interval, damage) = intact().unwrap();
        assert_eq!((interval, damage.len()), (Some(3), 1));
        assert!(damage[0].to_string().contains("optimizer-4.bpk: damaged"), "{}", damage[0]);
        fs::write(path(PARTS[0], 3), with_digest(b"record")).unwrap();
        let mut flipped = with_digest(b"record");
        flipped[2] ^= 8;
        fs::write(path(PARTS[2], 3), flipped).unwrap();
        assert!(intact().unwrap_err().to_string().contains("optimizer-4.bpk: damaged"));
    }
}
