//! Sequences of hands.

use std::path::Path;

use anyhow::Result;
use evpose_sim::{SequenceSet, Shard, Simulation, record_shard};
use evpose_task::hand::HandConfig;

use crate::progress::{bar, say};
use crate::run_info;

/// Records the sequences of `config` into `dir`, with config and seed beside them; `what` labels
/// the bar.
///
/// # Errors
/// If the simulation fails or a file cannot be written.
pub fn record(config: &HandConfig, dir: &Path, what: &str) -> Result<SimulationSummary> {
    run_info::write_shared(dir, config)?;
    record_shard_of(config, dir, Shard::WHOLE, what)
}

/// Records the missing sequences of a shard.
///
/// # Errors
/// If the simulation fails, a file cannot be written, or the directory is of another config.
pub fn record_shard_of(
    config: &HandConfig,
    dir: &Path,
    shard: Shard,
    what: &str,
) -> Result<SimulationSummary> {
    let simulation = Simulation::new(&config.simulation, config.seed)?;
    let set = SequenceSet::of_hands(dir, &config.simulation)?;
    let steps = set.unfinished(shard).len() as u64 * config.simulation.frames();
    let progress = bar(what, steps, "steps");
    let run = record_shard(&simulation, dir, shard, &|steps| progress.inc(steps))?;
    progress.finish_and_clear();
    // Another process may have begun here at the same time, with another config.
    run_info::check_shared(dir, config)?;
    Ok(SimulationSummary {
        sequences: run.sequences.len(),
        steps: run.sequences.iter().map(|sequence| sequence.frames).sum(),
        events: run.sequences.iter().map(|sequence| sequence.events).sum(),
        elapsed_s: run.elapsed.as_secs_f64(),
        parts: run.time.of(run.elapsed),
        reused: run.reused,
        leftovers: run.leftovers,
        finished: run.finished,
    })
}

/// Counts and duration of a simulation.
pub struct SimulationSummary {
    /// Sequences recorded by this run.
    pub sequences: usize,
    steps: u64,
    events: u64,
    elapsed_s: f64,
    /// Parts of that time.
    parts: String,
    reused: usize,
    leftovers: usize,
    /// Whether all sequences of the set are there.
    pub finished: bool,
}

impl SimulationSummary {
    /// Simulated steps of 1 ms per second of wall time.
    pub fn steps_per_second(&self) -> f64 {
        self.steps as f64 / self.elapsed_s
    }

    /// Prints how many complete sequences and unfinished files an earlier run left.
    pub fn report_earlier_work(&self) {
        if self.reused > 0 {
            say(format!("kept {} complete sequences", self.reused));
        }
        if self.leftovers > 0 {
            say(format!("removed {} unfinished files of an interrupted run", self.leftovers));
        }
    }
}

impl std::fmt::Display for SimulationSummary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} sequences, {} steps of 1 ms, {:.1} M events in {:.1} s ({}): {:.0} steps/s",
            self.sequences,
            self.steps,
            self.events as f64 / 1e6,
            self.elapsed_s,
            self.parts,
            self.steps_per_second()
        )
    }
}
