//! Arguments of `gapbench outside`.

use std::path::PathBuf;

use crate::program::ProgramArgs;

/// Arguments of `gapbench outside`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    gapbench outside cases/ --out runs/outside\n  \
    gapbench outside cases/ --out runs/outside-1 --shard 1/2 --resume -- --quick\n  \
    gapbench outside cases/ --score runs/outside-1 runs/outside-2 --out benches/gap/outside\n  \
    gapbench outside --score benches/gap/outside benches/gap/outside-ebf3f3a --out runs/pool\n\n\
    Every folder of cases/ holds events.npz, scene.json and frames.npy, which `evpose gap run` reads, \
    and truth.json, which is read only after the line of the case is in results.jsonl. Options after \
    -- are passed on to `evpose gap run`. benches/gap/outside.md describes how to make such cases.")]
pub(crate) struct OutsideArgs {
    /// Directory with a folder for every case; none for --score of folders with stored truths
    #[arg(required_unless_present = "score")]
    pub(super) cases: Option<PathBuf>,
    /// Directory for results and scores
    #[arg(long)]
    pub(super) out: PathBuf,
    /// Directory with the truth.json of every case, if they are not in the folders of the cases
    #[arg(long, value_name = "DIR")]
    pub(super) truth: Option<PathBuf>,
    /// Only score: directories of all shards
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["shard", "resume", "limit"])]
    pub(super) score: Vec<PathBuf>,
    /// Score the cases that are done, although some are not
    #[arg(long)]
    pub(super) partial: bool,
    /// Part of the cases, for example 1/4
    #[arg(long, default_value = "1/1", value_name = "I/N")]
    pub(super) shard: String,
    /// Continue: leave out the cases that are in results.jsonl already
    #[arg(long)]
    pub(super) resume: bool,
    /// Maximum number of cases
    #[arg(long)]
    pub(super) limit: Option<usize>,
    /// Keep the report of every case
    #[arg(long)]
    pub(super) keep: bool,
    #[command(flatten)]
    pub(super) program: ProgramArgs,
    /// Further options of `evpose gap run`
    #[arg(last = true, value_name = "OPTIONS")]
    pub(super) options: Vec<String>,
}
