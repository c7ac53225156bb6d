//! `evpose simulate` of people.

use crate::configs;
use crate::progress::say;
use crate::recorded::{claim, record_people_of, summary_of_people};
use anyhow::Result;
use evpose_sim::person::People;
use evpose_sim::set::MANIFEST;
use evpose_sim::{SequenceSet, Shard};
use evpose_task::Experiment as _;
use evpose_task::body::BodyConfig;

use super::args::BodySimulateArgs;
use crate::pages::people;
use crate::tasks::args::SimulateArgs;

pub(super) fn run(args: &SimulateArgs) -> Result<()> {
    let BodySimulateArgs { recording } = args.own.of(BodyConfig::TASK)?;
    let given = &args.config;
    let mut config: BodyConfig = configs::load_for_simulation(&given.config, &given.overrides)?;
    // Before the seed of what is held out is derived: no seed of a training is one of those.
    config.seed = args.seed.unwrap_or(config.seed);
    if args.held_out {
        config = config.held_out();
    }
    let simulation = &mut config.simulation;
    simulation.seconds = args.seconds.unwrap_or(simulation.seconds);
    simulation.sequences = args.sequences.unwrap_or(simulation.sequences);
    simulation.format = recording.format.or_else(|| simulation.format.take());
    config.validate()?;
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    let set = SequenceSet::of_people(&args.out, &config.simulation)?;
    claim(&set, &config, shard, args.resume)?;
    let recorded = record_people_of(&config, &args.out, shard)?;
    if recorded.reused > 0 {
        say(format!("kept {} complete sequences", recorded.reused));
    }
    say(summary_of_people(&recorded, &config));
    say(format!("written to {}", args.out.display()));
    if recorded.finished {
        say(format!("all {} sequences are there: {MANIFEST}", config.simulation.sequences));
    }
    if let Some(path) = &recording.preview {
        people::of_people(&People::new(&config.simulation, config.seed)?, path)?;
    }
    Ok(())
}
