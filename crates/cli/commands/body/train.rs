//! `evpose train` of bodies.

use std::path::Path;

use anyhow::{Context, Result};
use evpose_sim::set::PEOPLE;
use evpose_sim::{SequenceSet, Shard};
use evpose_train::TrainOptions;
use evpose_train::body::{
    BodyConfig, BodyFrames, BodyRecordings, BodySourceKind, BodyTrainSummary, train_body,
};

use super::simulate;
use crate::args::TrainArgs;
use crate::commands::use_threads;
use crate::progress::{bar, say};
use crate::run_info;

/// Where data are made that the command line does not name.
const DATA: &str = "data";

pub(crate) fn run(mut config: BodyConfig, args: &TrainArgs) -> Result<()> {
    use_threads(args.device.threads)?;
    if let Some(start) = &args.start_from {
        config.start_from = Some(start.clone());
    }
    let out = args.out.clone().unwrap_or_else(|| config.out.clone());
    let data = args.data.clone().unwrap_or_else(|| out.join(DATA));
    if args.data.is_none() && config.data.source.is_recorded() {
        prepare(&config, &data)?;
    }
    let frames = frames(&config, &data)?;
    let options = TrainOptions {
        device: args.device.device,
        resume: args.resume,
        plain: args.plain,
        told: None,
    };
    let summary = train_body(&config, frames, &out, &options)
        .with_context(|| format!("training in {}", out.display()))?;
    run_info::write(&out, config.seed, None)?;
    tell(&summary);
    Ok(())
}

/// Simulates the recordings of `config` where they are missing.
pub(crate) fn prepare(config: &BodyConfig, data: &Path) -> Result<()> {
    let set = SequenceSet::new(data, config.simulation.sequences).holding(PEOPLE);
    if set.unfinished(Shard::WHOLE).is_empty() {
        return run_info::check_shared(data, config);
    }
    run_info::write_shared(data, config)?;
    let simulation = &config.simulation;
    say(format!(
        "simulating {} people of {} s at {} into {}",
        simulation.sequences,
        simulation.seconds,
        simulation.sensor_size,
        data.display()
    ));
    let recorded = simulate::record(config, data, Shard::WHOLE)?;
    say(simulate::told(&recorded, config));
    Ok(())
}

/// The images that `config` trains on.
pub(crate) fn frames(config: &BodyConfig, data: &Path) -> Result<BodyFrames> {
    let (what, count) = match config.data.source {
        BodySourceKind::Stills | BodySourceKind::GreyStills => {
            ("photographing", config.data.stills)
        }
        BodySourceKind::Recordings | BodySourceKind::GreyRecordings => {
            ("looking", BodyRecordings::open(data)?.files.len() as u64)
        }
        BodySourceKind::Annotations => ("reading", 0),
    };
    let progress = bar(what, count, "");
    let frames = BodyFrames::of(config, data, &|done| progress.inc(done))?;
    progress.finish_and_clear();
    say(format!("{} images", frames.len()));
    Ok(frames)
}

fn tell(summary: &BodyTrainSummary) {
    say(format!(
        "{} images in {:.0} s, {:.0} images/s",
        summary.samples,
        summary.elapsed.as_secs_f64(),
        summary.samples_per_second
    ));
    say(summary.data_wait.to_string());
    if summary.ended_early {
        say("ended early: the validation loss had stopped falling");
    }
    say(format!("checkpoint: {}", summary.path.display()));
}
