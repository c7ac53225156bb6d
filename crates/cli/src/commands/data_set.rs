//! `evpose info DIR`: description and verification of a directory of sequences.

use std::path::Path;

use crate::tasks::{DataSetInfo, task_of_config};
use anyhow::{Context, Result, bail};
use evpose_sim::Shard;
use evpose_sim::set::{self, MANIFEST};

use crate::progress::{bar, say};
use crate::run_info::CONFIG;

/// Prints the contents of the directory and how much of them is complete.
pub(super) fn describe(directory: &Path) -> Result<()> {
    let path = directory.join(CONFIG);
    if !path.exists() {
        bail!("{}: not a directory of `evpose simulate`: no {CONFIG}", directory.display());
    }
    let DataSetInfo { content, sequences, seconds, seed, set } =
        task_of_config(&path.to_string_lossy())?.data_set(directory, &path)?;
    let unfinished = set.unfinished(Shard::WHOLE).len();
    let complete = sequences - unfinished;
    say(directory.display());
    say(format!("  content   {content}"));
    say(format!("  sequences {complete} of {sequences} complete"));
    say(format!("  duration  {seconds} s each, seed {seed}"));
    say(format!("  size      {:.3} GB", bytes_in(directory)? as f64 * 1e-9));
    say(match (set.manifest().exists(), unfinished) {
        // The run that completes a set writes it; shards that were copied together have none.
        (true, _) => format!("  manifest  {MANIFEST}"),
        (false, 0) => "  manifest  none yet: `evpose simulate … --resume` writes it".to_owned(),
        (false, _) => "  manifest  none: the set is not finished".to_owned(),
    });
    Ok(())
}

/// Compares every file with its digest; an unfinished set is an error too.
pub(super) fn verify(directory: &Path) -> Result<()> {
    let progress = bar("reading", bytes_in(directory)?, "bytes");
    let verified = set::verify(directory, &|bytes| progress.inc(bytes));
    progress.finish_and_clear();
    let verified = verified?;
    say(format!(
        "  verified  {} files, {:.3} GB, are as recorded",
        verified.files,
        verified.bytes as f64 * 1e-9
    ));
    if verified.leftovers > 0 {
        say(format!(
            "  leftovers {} unfinished files of interrupted runs, which readers ignore",
            verified.leftovers
        ));
    }
    // Digests of complete files prove nothing about those that are missing.
    if !verified.finished {
        bail!(
            "{}: no {MANIFEST}: finish the set with `evpose simulate … --resume`",
            directory.display()
        );
    }
    Ok(())
}

fn bytes_in(directory: &Path) -> Result<u64> {
    let reading = || format!("reading {}", directory.display());
    let mut bytes = 0;
    for entry in std::fs::read_dir(directory).with_context(reading)? {
        bytes += entry.and_then(|entry| entry.metadata()).with_context(reading)?.len();
    }
    Ok(bytes)
}
