//! Arguments of the commands about plans.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use gapbench_pixel::Tier;

use crate::program::ProgramArgs;

fn tier() -> impl TypedValueParser<Value = Tier> {
    let names = PossibleValuesParser::new(["home", "plain"]);
    names.map(|name| if name == "plain" { Tier::Plain } else { Tier::Home })
}

/// A plan.
#[derive(Debug, clap::Args)]
pub(crate) struct PlanArgs {
    /// Seed of the plan, or a TOML file with `seed = N`
    #[arg(long)]
    pub(crate) plan: String,
    /// Composition of the plan: zero to five effects in cameras with unmentioned conventions, or one
    /// or two effects in a pixel that is ideal otherwise
    #[arg(long, default_value = "home", value_parser = tier())]
    pub(crate) tier: Tier,
    /// Part of the plan, for example 1/4
    #[arg(long, default_value = "1/1", value_name = "I/N")]
    pub(crate) shard: String,
}

/// Cases of a plan.
#[derive(Debug, clap::Args)]
pub(crate) struct ChosenCases {
    #[command(flatten)]
    pub(crate) plan: PlanArgs,
    /// Maximum count of cases
    #[arg(long)]
    pub(crate) limit: Option<usize>,
    /// Only cases of these kinds
    #[arg(long, value_delimiter = ',',
          value_parser = ["single", "null", "parameter", "pair", "several", "left_out",
                          "never_catalogued"])]
    pub(crate) only: Vec<String>,
}

/// Arguments of `gapbench run`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    gapbench run --plan 7 --limit 12 --out runs/bench\n  \
    gapbench run --plan 7 --shard 1/2 --out runs/bench-1 --resume\n\n\
    Every case is written to files without its ground truth and identified from these files by `evpose gap run`. \
    A line per case goes to results.jsonl. A whole plan is scored at once; parts of it by `gapbench score`.")]
pub(crate) struct RunArgs {
    #[command(flatten)]
    pub(crate) cases: ChosenCases,
    #[command(flatten)]
    pub(crate) program: ProgramArgs,
    /// Directory for results and scores
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Continue: leave out the cases that are in results.jsonl already
    #[arg(long)]
    pub(crate) resume: bool,
    /// Keep the files and the report of every case
    #[arg(long)]
    pub(crate) keep: bool,
}

/// Arguments of `gapbench cases`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    gapbench cases --plan 7 --tier plain --limit 1 --out runs/guide\n  \
    gapbench cases --plan 11 --only several --limit 3 --truth --out runs/several\n\n\
    A case is a folder below cases/ with two recordings and their scenes, in the formats that `evpose gap run` \
    reads.")]
pub(crate) struct CasesArgs {
    #[command(flatten)]
    pub(crate) cases: ChosenCases,
    /// Directory for the files
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// With the ground truth of each case (truth.json); for plans of development
    #[arg(long)]
    pub(crate) truth: bool,
}

/// Arguments of `gapbench own`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
    gapbench own --plan 7 --sets 200 --out runs/bench-own --resume\n\n\
    Writes pvalues.csv, a line per recording. Of recordings in which nothing is missing, 5 % are significant at \
    5 %.")]
pub(crate) struct OwnArgs {
    #[command(flatten)]
    pub(crate) plan: PlanArgs,
    /// Count of recordings
    #[arg(long)]
    pub(crate) sets: usize,
    /// Directory for p-values
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Continue: leave out the recordings that are in pvalues.csv already
    #[arg(long)]
    pub(crate) resume: bool,
    /// CPU threads; all cores by default
    #[arg(long)]
    pub(crate) threads: Option<usize>,
}

/// Arguments of `gapbench score`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    gapbench score runs/bench-1 runs/bench-2 runs/bench-own --plan 7 --out runs/scores\n  \
    gapbench score benches/gap/plan-13439286 benches/gap/plan-161464479 --out runs/pool\n  \
    gapbench score benches/gap\n\n\
    With --plan, reads the ground truth of all cases, some seconds each, and writes results.jsonl, \
    labels.jsonl, scores.json, table.md, groups.csv, confusion.csv, power.csv, reliability.csv, \
    intervals.csv, times.csv and index.html. Without it, directories hold labels.jsonl already. \
    Without --out, makes scores and tables of all folders of a directory again, and the pages beside \
    them that show these.")]
pub(crate) struct ScoreArgs {
    /// Directories of `gapbench run` and `gapbench own`, or with stored labels
    #[arg(required = true, value_name = "DIR")]
    pub(crate) dirs: Vec<PathBuf>,
    /// Seed of the plan, or a TOML file with `seed = N`; none where labels are stored
    #[arg(long, requires = "out")]
    pub(crate) plan: Option<String>,
    /// Composition of the plan: zero to five effects in cameras with unmentioned conventions, or one
    /// or two effects in a pixel that is ideal otherwise
    #[arg(long, default_value = "home", value_parser = tier())]
    pub(crate) tier: Tier,
    /// Directory for scores, tables and page
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
    /// Score the cases that are done, although some are not
    #[arg(long)]
    pub(crate) partial: bool,
    /// CPU threads; all cores by default
    #[arg(long)]
    pub(crate) threads: Option<usize>,
}

/// Arguments of `gapbench calibrate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
    gapbench calibrate benches/gap --out crates/gap/src/workflow/calibration.json\n\n\
    Fits probabilities and intervals to all stored cases of all tiers, opened labels beside them, and \
    prints how well they hold of folders that a fit has not seen (calibration.md, beside the folders). \
    `evpose` has the written file in it.")]
pub(crate) struct CalibrateArgs {
    /// Directory of stored results
    #[arg(value_name = "DIR")]
    pub(crate) stored: PathBuf,
    /// File for the parameters of the fit
    #[arg(long)]
    pub(crate) out: PathBuf,
}
