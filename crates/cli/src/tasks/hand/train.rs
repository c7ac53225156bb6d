//! `evpose train` of hands.

use crate::configs;
use crate::shipped::checkpoint_path;
use anyhow::{Result, bail};
use evpose_task::hand::HandConfig;
use evpose_train::train_hand;
use evpose_train::training::TrainingSpan;

use crate::tasks::args::TrainArgs;
use crate::tasks::finish_training;

pub(super) fn run(args: &TrainArgs) -> Result<()> {
    let ([data], Some(out)) = (&args.data[..], &args.out) else {
        bail!("hands need one --data, a directory of sequences from `evpose simulate`, and --out");
    };
    let mut config: HandConfig = configs::load(&args.config.config, &args.config.overrides)?;
    if let Some(start) = &args.start_from {
        config.start_from = Some(checkpoint_path(start)?);
    }
    // An error now rather than after the simulation.
    args.device.open()?;
    let trained = train_hand(&config, data, out, &args.options());
    finish_training(trained, out, TrainingSpan::from(&config.training), config.seed, "samples")
}
