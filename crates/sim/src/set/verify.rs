//! Verification of a directory against its digests.

use std::collections::BTreeSet;
use std::path::Path;

use evpose_core::temporary_target;
use rayon::prelude::*;

use super::digest::FileDigest;
use super::fault::{DigestMismatch, MismatchKind};
use super::{DIGESTS, HANDS, MANIFEST, PEOPLE, list, manifest};
use crate::SimError;

/// Result of verifying an intact directory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Verified {
    /// Number of files read.
    pub files: usize,
    /// Their total size in bytes.
    pub bytes: u64,
    /// Whether there is a manifest; without one, the set is unfinished.
    pub finished: bool,
    /// Number of temporary files that killed processes left; readers ignore them.
    pub leftovers: usize,
}

/// Reads every file of the set in `directory` and compares it with the manifest or, while there is
/// none, with the digests of the complete sequences. `progress` receives the number of bytes of
/// each read.
///
/// # Errors
/// [`SimError::Damaged`] with every file that differs; a list of digests that cannot be read.
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
    // A file that nobody listed was added later: trained on, it would not be the published set.
    let unlisted = names
        .iter()
        .filter(|name| {
            [HANDS, PEOPLE].iter().any(|endings| has_ending(name, &endings[..2]))
                && !listed.contains(name.as_str())
        })
        .map(|name| DigestMismatch { path: directory.join(name), kind: MismatchKind::Unlisted });
    // Reading is what takes time: all threads take part.
    let mut faults: Vec<DigestMismatch> = expected
        .par_iter()
        .map(|digest| fault(directory, digest, progress))
        .collect::<Result<Vec<_>, _>>()?
        .into_iter()
        .flatten()
        .collect();
    faults.extend(unlisted);
    // All faults at once, so that a set is repaired in one go.
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

/// Compares one file with its digest.
fn fault(
    directory: &Path,
    expected: &FileDigest,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Option<DigestMismatch>, SimError> {
    let path = directory.join(&expected.name);
    if !path.exists() {
        return Ok(Some(DigestMismatch { path, kind: MismatchKind::Missing }));
    }
    let actual = FileDigest::compute(directory, &expected.name, progress)?;
    Ok((actual != *expected).then_some(DigestMismatch { path, kind: MismatchKind::Changed }))
}

/// Total size of the files that exist.
fn bytes_of<'a>(directory: &Path, names: impl Iterator<Item = &'a str>) -> u64 {
    names.filter_map(|name| Some(directory.join(name).metadata().ok()?.len())).sum()
}

fn has_ending(name: &str, endings: &[&str]) -> bool {
    let stem = |ending: &&str| name.strip_suffix(*ending);
    endings.iter().filter_map(stem).any(|stem| stem.ends_with('.'))
}
