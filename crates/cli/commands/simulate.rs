//! `evpose simulate`.

use std::path::Path;

use anyhow::{Context, Result, bail};
use evpose_core::atomic_write;
use evpose_sim::set::{HANDS, MANIFEST, PEOPLE};
use evpose_sim::{SequenceSet, Shard, Simulation, record_shard};
use evpose_train::{Condition, HandConfig};

use super::{body, config_source, use_threads};
use crate::args::SimulateArgs;
use crate::progress::{bar, say};
use crate::report::{self, views};
use crate::run_info::{self, RunConfig};

pub(crate) fn run(args: &SimulateArgs) -> Result<()> {
    use_threads(args.threads)?;
    if let Some(config) = body::config(&args.config)? {
        return body::simulate(config, args);
    }
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
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    let set = SequenceSet::new(&args.out, config.simulation.sequences);
    claim(&set, &config, shard, args.resume)?;
    let recorded = record_shard_of(&config, &args.out, shard, "simulating")?;
    recorded.say_what_was_there();
    if recorded.sequences > 0 {
        say(&recorded);
        say(format!("written to {}", args.out.display()));
    }
    say(if recorded.finished {
        format!("all {} sequences are there: {MANIFEST}", config.simulation.sequences)
    } else {
        format!("shard {shard} is complete; whoever records the last sequence writes {MANIFEST}")
    });
    if let Some(path) = &args.pictures {
        let sheet = views::sheet(&Simulation::new(&config.simulation, config.seed)?)?;
        atomic_write(path, &report::png(&sheet)?)
            .with_context(|| format!("writing {}", path.display()))?;
        say(format!("pictures: {}", path.display()));
    }
    Ok(())
}

/// Makes `dir` the directory of `config`'s sequences, or says why it cannot be.
pub(crate) fn claim(
    set: &SequenceSet,
    config: &impl RunConfig,
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
    // Shards that start together may all find nothing and write the same. Were one of them given
    // something else, only one config stays; who checked before that is told in the end.
    if !begun || (shard.is_whole() && !resume) {
        run_info::write_shared(dir, config)?;
    }
    run_info::check_shared(dir, config)
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
    run_info::write_shared(dir, config)?;
    record_shard_of(config, dir, Shard::WHOLE, what)
}

/// Records what is not yet there of a shard of the sequences.
fn record_shard_of(config: &HandConfig, dir: &Path, shard: Shard, what: &str) -> Result<Recorded> {
    let simulation = Simulation::new(&config.simulation, config.seed)?;
    let set = SequenceSet::new(dir, config.simulation.sequences);
    let steps = set.unfinished(shard).len() as u64 * config.simulation.frames();
    let progress = bar(what, steps, "steps");
    let run = record_shard(&simulation, dir, shard, &|steps| progress.inc(steps))?;
    progress.finish_and_clear();
    run_info::check_shared(dir, config)?;
    Ok(Recorded {
        sequences: run.sequences.len(),
        steps: run.sequences.iter().map(|sequence| sequence.frames).sum(),
        events: run.sequences.iter().map(|sequence| sequence.events).sum(),
        elapsed_s: run.elapsed.as_secs_f64(),
        kept: run.kept,
        leftovers: run.leftovers,
        finished: run.finished,
    })
}

/// What a simulation came to.
pub(crate) struct Recorded {
    sequences: usize,
    steps: u64,
    events: u64,
    elapsed_s: f64,
    kept: usize,
    leftovers: usize,
    finished: bool,
}

impl Recorded {
    pub(crate) fn steps_per_second(&self) -> f64 {
        self.steps as f64 / self.elapsed_s
    }

    /// What an earlier run left: sequences to keep, and files that nobody will finish.
    fn say_what_was_there(&self) {
        if self.kept > 0 {
            say(format!("kept {} complete sequences", self.kept));
        }
        if self.leftovers > 0 {
            say(format!("removed {} unfinished files of an interrupted run", self.leftovers));
        }
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
            .filter_map(|entry| entry.path().extension().map(std::ffi::OsStr::to_owned))
            .any(|extension| extension == HANDS[0] || extension == PEOPLE[0])
    })
}
