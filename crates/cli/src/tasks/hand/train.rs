//! `evpose train` of hands.

use crate::progress::say;
use crate::shipped::checkpoint_path;
use crate::{configs, run_info};
use anyhow::{Result, bail};
use evpose_task::hand::HandConfig;
use evpose_train::{TrainOptions, train_hand};

use crate::tasks::args::TrainArgs;
use crate::tasks::experiment::PoseExperiment as _;
use crate::tasks::learning_curves;

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
    let options = TrainOptions {
        device: args.device.device,
        resume: args.resume,
        plain: args.plain,
        progress: None,
        pause_after: None,
    };
    let trained = train_hand(&config, data, out, &options);
    // A training that failed is the worse fault.
    let curves = learning_curves::write_after(&trained, out, config.length());
    let summary = trained?;
    curves?;
    run_info::write(out, config.seed, None)?;
    say(format!(
        "{} samples in {:.0} s, {:.0} samples/s",
        summary.samples,
        summary.elapsed.as_secs_f64(),
        summary.samples_per_second
    ));
    say(summary.data_wait.to_string());
    say(format!("checkpoint: {}", summary.path.display()));
    Ok(())
}
