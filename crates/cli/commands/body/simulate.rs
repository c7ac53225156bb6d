//! `evpose simulate` of people.

use std::path::Path;

use anyhow::{Result, bail};
use evpose_sim::person::{People, RecordedPeople, record_people};
use evpose_sim::set::{MANIFEST, PEOPLE};
use evpose_sim::{SequenceSet, Shard};
use evpose_train::body::BodyConfig;

use super::pictures;
use crate::args::SimulateArgs;
use crate::commands::simulate::claim;
use crate::progress::{bar, say};
use crate::run_info;

pub(crate) fn run(mut config: BodyConfig, args: &SimulateArgs) -> Result<()> {
    if args.condition.is_some() {
        bail!(
            "--condition is for hands: people have `--set simulation.light_level=0.01` and the like"
        );
    }
    if args.held_out {
        config = config.held_out();
    }
    let simulation = &mut config.simulation;
    simulation.seconds = args.seconds.unwrap_or(simulation.seconds);
    simulation.sequences = args.sequences.unwrap_or(simulation.sequences);
    config.seed = args.seed.unwrap_or(config.seed);
    config.validate()?;
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    let set = SequenceSet::new(&args.out, config.simulation.sequences).holding(PEOPLE);
    claim(&set, &config, shard, args.resume)?;
    let recorded = record(&config, &args.out, shard)?;
    if recorded.kept > 0 {
        say(format!("kept {} complete sequences", recorded.kept));
    }
    say(told(&recorded, &config));
    say(format!("written to {}", args.out.display()));
    if recorded.finished {
        say(format!("all {} sequences are there: {MANIFEST}", config.simulation.sequences));
    }
    if let Some(path) = &args.pictures {
        pictures::of_people(&People::new(&config.simulation, config.seed)?, path)?;
    }
    Ok(())
}

/// Records what is not yet there of the people of `config`.
pub(super) fn record(config: &BodyConfig, dir: &Path, shard: Shard) -> Result<RecordedPeople> {
    let people = People::new(&config.simulation, config.seed)?;
    let set = SequenceSet::new(dir, config.simulation.sequences).holding(PEOPLE);
    let steps = set.unfinished(shard).len() as u64 * config.simulation.steps();
    let progress = bar("simulating", steps, "steps");
    let recorded = record_people(&people, dir, shard, &|steps| progress.inc(steps))?;
    progress.finish_and_clear();
    run_info::check_shared(dir, config)?;
    Ok(recorded)
}

/// What a simulation came to, in a line.
pub(super) fn told(recorded: &RecordedPeople, config: &BodyConfig) -> String {
    let seconds = recorded.elapsed.as_secs_f64();
    format!(
        "{} sequences, {} steps of {} ms, {:.1} M events in {seconds:.1} s: {:.0} steps/s",
        recorded.sequences,
        recorded.steps,
        config.simulation.step().0 as f64 / 1e3,
        recorded.events as f64 / 1e6,
        recorded.steps as f64 / seconds,
    )
}
