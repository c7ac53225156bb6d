//! `evpose simulate`.

use std::path::Path;

use anyhow::{Result, bail};
use evpose_sim::{Simulation, record_all};
use evpose_train::{Condition, HandConfig};

use super::{config_source, use_threads};
use crate::args::SimulateArgs;
use crate::progress::{bar, say};
use crate::run_info;

pub(crate) fn run(args: &SimulateArgs) -> Result<()> {
    use_threads(args.threads)?;
    let mut config = config_source::load(&args.config.config, &args.config.overrides)?;
    if let Some(condition) = &args.condition {
        config = Condition::load(condition)?.apply(&config)?;
    }
    if args.held_out {
        config = held_out(&config);
    }
    let simulation = &mut config.simulation;
    simulation.seconds = args.seconds.unwrap_or(simulation.seconds);
    simulation.sequences = args.sequences.unwrap_or(simulation.sequences);
    config.seed = args.seed.unwrap_or(config.seed);
    config.simulation.validate()?;
    if holds_sequences(&args.out) {
        bail!("{} already holds sequences: choose another --out", args.out.display());
    }
    let recorded = record(&config, &args.out, "simulating")?;
    say(&recorded);
    say(format!("written to {}", args.out.display()));
    Ok(())
}

/// The experiment's held-out recordings: their number and length, and a seed nothing else uses.
pub(crate) fn held_out(config: &HandConfig) -> HandConfig {
    let mut config = config.clone();
    config.seed = evpose_core::seed_for(config.seed, "held out", 0) >> 1;
    config.simulation.sequences = config.evaluation.sequences;
    config.simulation.seconds = config.evaluation.seconds;
    config
}

/// Records the sequences of `config` into `dir`, with config and seed beside them.
pub(crate) fn record(config: &HandConfig, dir: &Path, what: &str) -> Result<Recorded> {
    run_info::write(dir, config.seed, Some(config))?;
    let simulation = Simulation::new(&config.simulation, config.seed)?;
    let steps = config.simulation.sequences as u64 * config.simulation.frames();
    let progress = bar(what, steps, "steps");
    let run = record_all(&simulation, dir, &|steps| progress.inc(steps))?;
    progress.finish_and_clear();
    Ok(Recorded {
        sequences: run.sequences.len(),
        steps,
        events: run.sequences.iter().map(|sequence| sequence.events).sum(),
        elapsed_s: run.elapsed.as_secs_f64(),
    })
}

/// What a simulation came to.
pub(crate) struct Recorded {
    sequences: usize,
    steps: u64,
    events: u64,
    elapsed_s: f64,
}

impl Recorded {
    pub(crate) fn steps_per_second(&self) -> f64 {
        self.steps as f64 / self.elapsed_s
    }
}

impl std::fmt::Display for Recorded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} sequences, {} steps of 1 ms, {:.1} M events in {:.1} s: {:.0} steps/s",
            self.sequences,
            self.steps,
            self.events as f64 / 1e6,
            self.elapsed_s,
            self.steps_per_second()
        )
    }
}

fn holds_sequences(dir: &Path) -> bool {
    std::fs::read_dir(dir).is_ok_and(|entries| {
        entries
            .filter_map(Result::ok)
            .any(|entry| entry.path().extension().is_some_and(|extension| extension == "evc"))
    })
}
