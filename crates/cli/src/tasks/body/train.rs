//! `evpose train` of bodies.

use anyhow::{Context, Result};
use evpose_task::body::{BodyCheckpoint, BodyConfig};
use evpose_train::body::{BodyFrames, train_body};
use evpose_train::{TrainOptions, TrainSummary};

use crate::progress::say;
use crate::shipped::checkpoint_path;
use crate::tasks::args::TrainArgs;
use crate::tasks::experiment::PoseExperiment as _;
use crate::tasks::learning_curves;
use crate::{configs, recorded, run_info};

/// Directory of simulated data in a run, without --data.
const DATA: &str = "data";

pub(super) fn run(args: &TrainArgs) -> Result<()> {
    let mut config: BodyConfig = configs::load(&args.config.config, &args.config.overrides)?;
    // An error now rather than after the simulation.
    args.device.open()?;
    if let Some(start) = &args.start_from {
        config.start_from = Some(checkpoint_path(start)?);
    }
    let out = args.out.clone().unwrap_or_else(|| config.out.clone());
    let mut data = args.data.clone();
    if data.is_empty() {
        data.push(out.join(DATA));
        if config.data.source.is_recorded() {
            recorded::prepare(&config, &data[0])?;
        }
    }
    let mut frames = BodyFrames::default();
    for data in &data {
        frames.append(recorded::frames(&config, data)?);
    }
    let options = TrainOptions {
        device: args.device.device,
        resume: args.resume,
        plain: args.plain,
        progress: None,
        pause_after: None,
    };
    let trained = train_body(&config, frames, &out, &options);
    // A training that failed is the worse fault.
    let curves = learning_curves::write_after(&trained, &out, config.length());
    let summary = trained.with_context(|| format!("training in {}", out.display()))?;
    curves?;
    run_info::write(&out, config.seed, None)?;
    print_summary(&summary);
    Ok(())
}

fn print_summary(summary: &TrainSummary<BodyCheckpoint>) {
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
