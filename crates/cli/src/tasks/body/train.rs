//! `evpose train` of bodies.

use anyhow::Result;
use evpose_task::Experiment as _;
use evpose_task::body::BodyConfig;
use evpose_train::body::{BodyFrames, train_body};
use evpose_train::training::TrainingSpan;

use super::args::BodyTrainArgs;
use crate::progress::note;
use crate::tasks::args::TrainArgs;
use crate::tasks::finish_training;
use crate::{configs, recorded};

/// Directory of simulated data in a run, without --data.
const DATA: &str = "data";

pub(super) fn run(args: &TrainArgs) -> Result<()> {
    let BodyTrainArgs { mut data, out, start } = args.own.of(BodyConfig::TASK)?;
    let mut config: BodyConfig = configs::load(&args.config.config, &args.config.overrides)?;
    // An error now rather than after the simulation.
    args.device.open()?;
    config.start_from = start.or(config.start_from.take())?;
    let out = out.unwrap_or_else(|| config.out.clone());
    if data.is_empty() {
        data.push(out.join(DATA));
        // Stills are drawn as they are loaded, so that nothing of them has to be on disk.
        if config.data.source.is_recorded() {
            recorded::prepare(&config, &data[0])?;
        }
    }
    let mut frames = BodyFrames::default();
    for data in &data {
        frames.append(recorded::frames(&config, data)?);
    }
    let unlabelled = frames.unlabelled_joints();
    if !unlabelled.is_empty() {
        note(format!(
            "note: no label of {}: the accuracy of the validation leaves them out",
            unlabelled.join(", ")
        ));
    }
    let trained = train_body(&config, frames, &out, &args.options());
    finish_training(trained, &out, TrainingSpan::from(&config.training), config.seed, "images")
}
