//! `evpose train`.

use anyhow::{Result, bail};
use evpose_train::{TrainOptions, train_hand};

use super::body;
use evpose_app::args::ConfigArgs;
use evpose_app::args::DeviceArgs;
use evpose_app::body_config;
use evpose_app::hand_config;
use evpose_app::progress::say;
use evpose_app::run_info;
use evpose_app::threads::use_threads;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose train quick --data data/train --out runs/hand\n  \
    evpose train quick --data data/train --out runs/hand --resume\n  \
    evpose train configs/body/pretrain.toml\n  \
    evpose train configs/body/finetune.toml")]
pub(crate) struct TrainArgs {
    #[command(flatten)]
    pub(crate) config: ConfigArgs,
    /// Directory of sequences from `evpose simulate`, or of images from `evpose prepare`, or the annotation
    /// file of the latter. Bodies: made in OUT/data where it is missing
    #[arg(long)]
    pub(crate) data: Option<PathBuf>,
    /// Directory of the run [bodies: the config's `out`]
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
    /// A run or a file of weights to start from [bodies: the config's `start_from`]
    #[arg(long, value_name = "RUN")]
    pub(crate) start_from: Option<PathBuf>,
    /// Continue an interrupted run from its newest checkpoint
    #[arg(long)]
    pub(crate) resume: bool,
    /// Plain lines instead of the dashboard, even on a terminal
    #[arg(long)]
    pub(crate) plain: bool,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

pub(crate) fn run(args: &TrainArgs) -> Result<()> {
    evpose_kernels::keep_freed_memory();
    if let Some(config) = body_config::config(&args.config)? {
        return body::train(config, args);
    }
    let (Some(data), Some(out)) = (&args.data, &args.out) else {
        bail!("hands need --data, a directory of sequences from `evpose simulate`, and --out");
    };
    if args.start_from.is_some() {
        bail!("--start-from is for bodies: networks of hands are trained from the beginning");
    }
    let config = hand_config::load(&args.config.config, &args.config.overrides)?;
    use_threads(args.device.threads)?;
    let options = TrainOptions {
        device: args.device.device,
        resume: args.resume,
        plain: args.plain,
        told: None,
    };
    let summary = train_hand(&config, data, out, &options)?;
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
