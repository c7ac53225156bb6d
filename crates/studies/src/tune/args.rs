//! Arguments of `evpose tune`.

use std::path::PathBuf;

use crate::study::StudyArgs;

/// Arguments of `evpose tune`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose tune quick --over over.toml --out runs/tune\n  \
    evpose tune quick --over over.toml --method halving --trials 27 --data data/train --out runs/tune\n  \
    evpose tune finetune --over over.toml --rank accuracy --out runs/tune-body --resume\n  \
    evpose tune quick --over over.toml --data data/train --out runs/tune --shard 3/8 --resume\n  \
    evpose train runs/tune/best.toml --data data/train --out runs/best\n\n\
    FILE of --over, by fields of the config:\n  \
    [training]\n  \
    learning_rate = { log_uniform = [1e-4, 1e-2] }\n  \
    batch_size = { choose = [16, 32, 64] }\n  \
    [network]\n  \
    width = { uniform = [0.1, 0.2] }\n\n\
    and { integer = [2, 8] }, both ends included. Trial 0 is the config as it is. Trials are ranked by \
    a value of validation at the checkpoint that a training keeps, the one of the lowest validation \
    loss: by the loss itself, which every training measures anyway, or by another logged value where \
    losses cannot be compared, as when their weights are searched. Hands log loss, articulation, \
    translation (mm) and rotation (degrees); bodies loss, accuracy (PCK@0.2 of one pass) and the parts \
    of the loss. Outputs: tune.html, tune.json, trials.csv and best.toml. docs/guide/tune.md says more.")]
pub struct TuneArgs {
    /// A TOML file, or an embedded config: for hands `quick`, `hand-wide`, `hand-joints`, `ablation`,
    /// `eventhands`, for bodies `pretrain`, `finetune`, `body-wide`, `studio`, `pretrain-full`, `finetune-full`
    pub config: String,
    /// A TOML file: fields of the config, and how each is drawn
    #[arg(long, value_name = "FILE")]
    pub over: PathBuf,
    /// random: every trial is trained to the end. halving: all are trained for a short time, and the
    /// best of them for longer, again and again
    #[arg(long, value_enum, default_value_t = TuneMethod::Random)]
    pub method: TuneMethod,
    /// Number of trials, that of the config as it is included
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub trials: u64,
    /// Halving: the best of each of these many trials goes on, for this many times as long
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u64).range(2..=100))]
    pub eta: u64,
    /// Halving: number of rungs [default: as many as the trials and the validations of a training
    /// allow]
    #[arg(long, value_parser = clap::value_parser!(u32).range(2..=20))]
    pub rungs: Option<u32>,
    /// The logged value of validation that trials are ranked by
    #[arg(long, value_name = "VALUE", default_value = evpose_train::LOSS)]
    pub rank: String,
    /// Training data of all trials, as `evpose train` takes them [default: simulated into OUT/data]
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    /// A run, or a file of weights, that every trial starts from [default: the config's]
    #[arg(long, value_name = "RUN")]
    pub start_from: Option<PathBuf>,
    /// Directory, changes to the config, device.
    #[command(flatten)]
    pub study: StudyArgs,
}

/// The methods of search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TuneMethod {
    /// Every trial is trained to the end.
    Random,
    /// Successive halving.
    Halving,
}
