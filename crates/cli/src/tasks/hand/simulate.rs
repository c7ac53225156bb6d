//! `evpose simulate` of hands.

use crate::configs;
use crate::outputs::write_file;
use crate::pages::camera_views;
use crate::progress::say;
use crate::recorded::{claim, record_shard_of};
use anyhow::Result;
use evpose_report::png::png;
use evpose_sim::set::MANIFEST;
use evpose_sim::{SequenceSet, Shard, Simulation};
use evpose_task::Experiment as _;
use evpose_task::hand::HandConfig;
use evpose_train::Condition;

use super::args::HandSimulateArgs;
use crate::tasks::args::SimulateArgs;

pub(super) fn run(args: &SimulateArgs) -> Result<()> {
    let HandSimulateArgs { recording, condition } = args.own.of(HandConfig::TASK)?;
    let given = &args.config;
    let mut config: HandConfig = configs::load_for_simulation(&given.config, &given.overrides)?;
    if let Some(condition) = &condition {
        config = Condition::load(condition)?.apply(&config)?;
    }
    // Before the seed of what is held out is derived: no seed of a training is one of those.
    config.seed = args.seed.unwrap_or(config.seed);
    if args.held_out {
        config = config.held_out();
    }
    let simulation = &mut config.simulation;
    simulation.seconds = args.seconds.unwrap_or(simulation.seconds);
    simulation.sequences = args.sequences.unwrap_or(simulation.sequences);
    simulation.format = recording.format.or_else(|| simulation.format.take());
    config.simulation.validate()?;
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    let set = SequenceSet::of_hands(&args.out, &config.simulation)?;
    claim(&set, &config, shard, args.resume)?;
    let recorded = record_shard_of(&config, &args.out, shard, "simulating")?;
    recorded.report_earlier_work();
    if recorded.sequences > 0 {
        say(&recorded);
        say(format!("written to {}", args.out.display()));
    }
    say(if recorded.finished {
        format!("all {} sequences are there: {MANIFEST}", config.simulation.sequences)
    } else {
        format!("shard {shard} is complete; whoever records the last sequence writes {MANIFEST}")
    });
    // The preview simulates once more, and comes when the sequences are on disk.
    if let Some(path) = &recording.preview {
        let sheet = camera_views::sheet(&Simulation::new(&config.simulation, config.seed)?)?;
        write_file(path, &png(&sheet)?)?;
        say(format!("preview: {}", path.display()));
    }
    Ok(())
}
