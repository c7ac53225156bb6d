//! Arguments of the benchmark of the gap workflow.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use gapbench_pixel::Tier;

/// Parses the composition of a plan.
fn tier() -> impl TypedValueParser<Value = Tier> {
    let names = PossibleValuesParser::new(["home", "plain"]);
    names.map(|name| if name == "plain" { Tier::Plain } else { Tier::Home })
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    evpose gap bench --plan 7 --limit 12 --out runs/bench\n  \
    evpose gap bench --plan 7 --shard 1/2 --out runs/bench-1 --resume\n  \
    evpose gap bench --plan 7 --self 200 --out runs/bench-self --resume\n  \
    evpose gap bench --plan 11 --only several --limit 3 --cases --out runs/cases\n\n\
    Every case is written to files without its ground truth and identified from these files. A line per case goes \
    to results.jsonl. A whole plan is scored at once; parts of it by `evpose gap score`.")]
/// Arguments of `evpose gap bench`.
pub struct BenchArgs {
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
    /// Continue: leave out the cases that are in results.jsonl already
    #[arg(long)]
    pub(crate) resume: bool,
    /// Maximum number of cases
    #[arg(long)]
    pub(crate) limit: Option<usize>,
    /// Instead of cases: N recordings simulated by the model itself, in scenes of the plan, with the p-value
    /// of each
    #[arg(long = "self", value_name = "N", conflicts_with_all = ["limit", "only", "keep"])]
    pub(crate) own: Option<usize>,
    /// Only cases of these kinds
    #[arg(long, value_delimiter = ',',
          value_parser = ["single", "null", "parameter", "pair", "several", "left_out",
                          "never_catalogued"])]
    pub(crate) only: Vec<String>,
    /// Directory for results and scores
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Keep the files of the cases
    #[arg(long)]
    pub(crate) keep: bool,
    /// Write the files of the cases with their ground truth (truth.json) and identify nothing; for
    /// plans of development
    #[arg(long, conflicts_with_all = ["own", "resume", "keep"])]
    pub(crate) cases: bool,
    /// CPU threads; all cores by default
    #[arg(long)]
    pub(crate) threads: Option<usize>,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    evpose gap score runs/bench-1 runs/bench-2 runs/bench-self --plan 7 --out runs/scores\n  \
    evpose gap score benches/gap/plan-13439286 benches/gap/plan-161464479 --out runs/pool\n  \
    evpose gap score benches/gap\n\n\
    With --plan, reads the ground truth of all cases, some seconds each, and writes results.jsonl, \
    labels.jsonl, scores.json, table.md, groups.csv, confusion.csv, power.csv, reliability.csv, \
    intervals.csv, times.csv and index.html. Without it, directories hold labels.jsonl already. \
    Without --out, makes scores and tables of all folders of a directory again, and the pages beside \
    them that show these.")]
/// Arguments of `evpose gap score`.
pub struct ScoreArgs {
    /// Directories of `evpose gap bench`, or with stored labels
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

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
    evpose gap calibrate benches/gap --out crates/gap/src/workflow/calibration.json\n\n\
    Fits probabilities and intervals to all stored cases of all tiers, opened labels beside them, and \
    prints how well they hold of folders that a fit has not seen (calibration.md, beside the folders). \
    The program has the written file in it.")]
/// Arguments of `evpose gap calibrate`.
pub struct CalibrateArgs {
    /// Directory of stored results
    #[arg(value_name = "DIR")]
    pub(crate) stored: PathBuf,
    /// File for the parameters of the fit
    #[arg(long)]
    pub(crate) out: PathBuf,
}
