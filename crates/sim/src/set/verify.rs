//! Whether a directory still holds what was recorded.

use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};

use evpose_core::temporary_target;
use rayon::prelude::*;

use super::digest::FileDigest;
use super::{DIGESTS, HANDS, MANIFEST, PEOPLE, list, manifest};
use crate::SimError;

/// A directory in which every file is as it was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Verified {
    /// Files that were read.
    pub files: usize,
    /// Their bytes.
    pub bytes: u64,
    /// Whether there is a manifest: without one, the set is not finished.
    pub finished: bool,
    /// Files that killed processes left behind, which no reader looks at.
    pub leftovers: usize,
}

/// A file that is not as it was recorded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub kind: FaultKind,
}

/// What can be wrong with a file of a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// It is gone.
    Missing,
    /// It holds something else.
    Changed,
    /// No digest tells what it should hold, and readers would take it for a sequence of the set.
    Unlisted,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.kind {
            FaultKind::Missing => "is missing",
            FaultKind::Changed => "is not what was recorded",
            FaultKind::Unlisted => "has no digest: unfinished, or not of this set",
        };
        write!(f, "{} {what}", self.path.display())
    }
}

/// Reads every file of the set in `directory` and compares it with the manifest or, while there is
/// none, with the digests of the sequences that are there. `progress` is told of bytes read.
///
/// # Errors
/// [`SimError::Damaged`] with every file that is not as recorded; a list of digests that cannot be
/// read.
pub fn verify(directory: &Path, progress: &(dyn Fn(u64) + Sync)) -> Result<Verified, SimError> {
    let names = list(directory)?;
    let finished = names.iter().any(|name| name == MANIFEST);
    let mut expected = Vec::new();
    if finished {
        expected = manifest::read(&directory.join(MANIFEST))?;
    } else {
        for name in names.iter().filter(|name| has_ending(name, &[DIGESTS])) {
            expected.extend(manifest::read(&directory.join(name))?);
        }
    }
    let listed: BTreeSet<&str> = expected.iter().map(|digest| digest.name.as_str()).collect();
    let unlisted = names
        .iter()
        .filter(|name| {
            (has_ending(name, &HANDS[..2]) || has_ending(name, &PEOPLE[..2]))
                && !listed.contains(name.as_str())
        })
        .map(|name| Fault { path: directory.join(name), kind: FaultKind::Unlisted });
    let mut faults: Vec<Fault> = expected
        .par_iter()
        .map(|digest| fault(directory, digest, progress))
        .collect::<Result<Vec<_>, _>>()?
        .into_iter()
        .flatten()
        .collect();
    faults.extend(unlisted);
    if !faults.is_empty() {
        let directory = directory.to_owned();
        return Err(SimError::Damaged { directory, files: expected.len(), faults });
    }
    Ok(Verified {
        files: expected.len(),
        bytes: bytes_of(directory, expected.iter().map(|digest| digest.name.as_str())),
        finished,
        leftovers: names.iter().filter(|name| temporary_target(name).is_some()).count(),
    })
}

fn fault(
    directory: &Path,
    expected: &FileDigest,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Option<Fault>, SimError> {
    let path = directory.join(&expected.name);
    if !path.exists() {
        return Ok(Some(Fault { path, kind: FaultKind::Missing }));
    }
    let found = FileDigest::of(directory, &expected.name, progress)?;
    Ok((found != *expected).then_some(Fault { path, kind: FaultKind::Changed }))
}

/// Bytes of the files, as far as they are there.
fn bytes_of<'a>(directory: &Path, names: impl Iterator<Item = &'a str>) -> u64 {
    names.filter_map(|name| Some(directory.join(name).metadata().ok()?.len())).sum()
}

fn has_ending(name: &str, endings: &[&str]) -> bool {
    name.rsplit_once('.').is_some_and(|(_, ending)| endings.contains(&ending))
}
