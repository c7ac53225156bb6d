//! `evpose train` of hands.

use crate::configs;
use anyhow::Result;
use evpose_task::Experiment as _;
use evpose_task::hand::HandConfig;
use evpose_train::train_hand;
use evpose_train::training::TrainingSpan;

use super::args::HandTrainArgs;
use crate::tasks::args::{DirectoryArgs, TrainArgs};
use crate::tasks::finish_training;

pub(super) fn run(args: &TrainArgs) -> Result<()> {
    let HandTrainArgs { directories: DirectoryArgs { data, out }, start } =
        args.own.of(HandConfig::TASK)?;
    let mut config: HandConfig = configs::load(&args.config.config, &args.config.overrides)?;
    config.start_from = start.or(config.start_from.take())?;
    // An error now rather than after the simulation.
    args.device.open()?;
    let trained = train_hand(&config, &data, &out, &args.options());
    finish_training(trained, &out, TrainingSpan::from(&config.training), config.seed, "samples")
}
