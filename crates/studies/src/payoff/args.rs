//! Arguments of `evpose gap payoff`.

use std::path::PathBuf;

use evpose_cli::tasks::TASKS;

use crate::study::{SeedArgs, StudyArgs};
use evpose_cli::ranges::count;

/// Arguments of `evpose gap payoff`.
#[derive(Debug, clap::Args)]
#[command(
    mut_arg("seeds", |seeds| seeds.default_value("1")),
    group = clap::ArgGroup::new("recordings").required(true).args(["data", "camera"]),
    after_help = "Examples:\n  \
    evpose gap payoff gap/ --camera camera.toml --out payoff/\n  \
    evpose gap payoff gap/ --data recordings/ --out payoff/ --set training.steps=4000\n  \
    evpose gap payoff gap/ --camera camera.toml --upper-bound --seeds 3 --out payoff/ --resume\n  \
    evpose gap payoff gap/ --camera camera.toml --task body --out payoff/\n\n\
    gap/ is a directory of `evpose gap run`: model.toml is the model as given, corrected.toml the \
    corrected one. Intervals are over recordings. They hold for the networks that were trained: \
    --seeds repeats simulation and training, and the differences under each seed are listed."
)]
pub struct PayoffArgs {
    /// A directory of `evpose gap run`
    pub gap: PathBuf,
    /// Recordings of the measured camera with known poses, as `evpose eval --data` takes them
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    /// The measured camera, where its effects are known: a preset or a TOML file, with which
    /// held-out recordings are simulated
    #[arg(long, value_name = "FILE")]
    pub camera: Option<PathBuf>,
    /// Also train on simulations of --camera: the most that a correction can be worth
    #[arg(long, conflicts_with = "data")]
    pub upper_bound: bool,
    /// The task, whose quick config is the default of --config [default: that of --config, or hand]
    #[arg(long, value_parser = task_names())]
    pub task: Option<String>,
    /// Config of simulation, training and evaluation: a TOML file, or an embedded config [default:
    /// `quick` for hands, `finetune` for bodies]
    #[arg(long)]
    pub config: Option<String>,
    /// Bodies: a run or a file of weights that every training starts from [default: initial
    /// weights]
    #[arg(long, value_name = "RUN")]
    pub start_from: Option<PathBuf>,
    /// Repetitions, each with the next seed.
    #[command(flatten)]
    pub seeds: SeedArgs,
    /// Milliseconds between the poses that are evaluated [hands: 5; bodies: the config's]
    #[arg(long, value_parser = count::<u32>())]
    pub stride_ms: Option<u32>,
    /// Directory, changes to the config, device.
    #[command(flatten)]
    pub study: StudyArgs,
}

fn task_names() -> clap::builder::PossibleValuesParser {
    TASKS.names().into()
}
