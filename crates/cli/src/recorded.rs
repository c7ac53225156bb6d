//! Simulated data sets on disk: recorded where they are missing, with config and seed beside them.

mod hand;
mod people;

use std::path::Path;

use anyhow::{Result, bail};
use evpose_sim::set::{HANDS, PEOPLE};
use evpose_sim::{SequenceSet, Shard};
use evpose_task::Experiment;

pub use hand::{SimulationSummary, record, record_shard_of};
pub use people::{frames, prepare, record as record_people_of, summary_of_people};

use crate::run_info;

/// Claims `dir` for the sequences of `config`.
///
/// # Errors
/// If the directory belongs to another config, or holds sequences and `resume` is not set.
pub fn claim(
    set: &SequenceSet,
    config: &impl Experiment,
    shard: Shard,
    resume: bool,
) -> Result<()> {
    let dir = set.directory();
    let others = holds_sequences(dir);
    let ours = if shard.is_whole() { others } else { set.holds_any(shard) };
    if ours && !resume {
        bail!(
            "{} already holds sequences: add --resume to finish them, or choose another --out",
            dir.display()
        );
    }
    let begun = dir.join(run_info::CONFIG).exists();
    if others && !begun {
        bail!(
            "{} already holds sequences, and no {} says which: choose another --out",
            dir.display(),
            run_info::CONFIG
        );
    }
    // Shards that start at the same time may all find no config and write the same. If one had another
    // config, one file wins, and the final check of the other shards fails.
    if !begun || (shard.is_whole() && !resume) {
        run_info::write_shared(dir, config)?;
    }
    run_info::check_shared(dir, config)
}

fn holds_sequences(dir: &Path) -> bool {
    std::fs::read_dir(dir).is_ok_and(|entries| {
        entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).any(|name| {
            // All but the descriptions, whose ending others have as well.
            HANDS
                .iter()
                .chain(&PEOPLE)
                .filter(|ending| **ending != "toml")
                .any(|ending| name.strip_suffix(ending).is_some_and(|stem| stem.ends_with('.')))
        })
    })
}
