//! Verification of a directory against its digests.

use std::collections::{BTreeMap, BTreeSet};
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
    }
    let in_manifest: BTreeMap<_, _> =
        expected.iter().map(|digest| (digest.name.clone(), digest.sha256.clone())).collect();
    let of_manifest = |digest: &FileDigest| in_manifest.get(&digest.name) == Some(&digest.sha256);
    // Those of the sequence that has this list of digests.
    let files_in_manifest = |list: &str| {
        let stem = list.trim_end_matches(DIGESTS);
        let files = in_manifest.range(stem.to_owned()..);
        files.take_while(|(name, _)| name.starts_with(stem)).count()
    };
    let mut faults = Vec::new();
    for name in names.iter().filter(|name| of_sequence(name, &[DIGESTS])) {
        let path = directory.join(name);
        let digests = manifest::read(&path)?;
        if !finished {
            expected.extend(digests);
        } else if digests.len() != files_in_manifest(name)
            || digests.iter().any(|digest| !of_manifest(digest))
        {
            faults.push(DigestMismatch { path, kind: MismatchKind::Changed });
        }
    }
    let listed: BTreeSet<&str> = expected.iter().map(|digest| digest.name.as_str()).collect();
    // A file that nobody listed was added later: trained on, it would not be the published set.
    let unlisted = names
        .iter()
        .filter(|name| {
            [&HANDS[..], &PEOPLE].iter().any(|endings| of_sequence(name, endings))
                && !listed.contains(name.as_str())
        })
        .map(|name| DigestMismatch { path: directory.join(name), kind: MismatchKind::Unlisted });
    // Reading is what takes time: all threads take part.
    let differing = expected.par_iter().map(|digest| fault(directory, digest, progress));
    faults.extend(differing.collect::<Result<Vec<_>, _>>()?.into_iter().flatten());
    faults.extend(unlisted);
    // All faults at once, so that a set is repaired in one go.
    if !faults.is_empty() {
        let directory = directory.to_owned();
        return Err(SimError::Damaged { directory, files: expected.len(), faults });
    }
    let size = |digest: &FileDigest| Some(directory.join(&digest.name).metadata().ok()?.len());
    Ok(Verified {
        files: expected.len(),
        bytes: expected.iter().filter_map(size).sum(),
        finished,
        leftovers: names.iter().filter(|name| temporary_target(name).is_some()).count(),
    })
}

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

/// Whether a file is one of a sequence, `0007.evc`: a set's own files, as `config.toml`, are not listed.
fn of_sequence(name: &str, endings: &[&str]) -> bool {
    name.split_once('.').is_some_and(|(number, ending)| {
        number.bytes().all(|byte| byte.is_ascii_digit()) && endings.contains(&ending)
    })
}
