//! `evpose gap bench`: effects hidden in recordings of an independent pixel, and what is found.
//!
//! ```text
//! naming   every case as the files of a measurement, without its label; a row a case
//!   -> merge    rows of all parts of a plan, each case once
//!   -> opened   the label of each case that has a row
//!   -> group    recall and precision by the count of hidden effects
//!   -> score    rates, power, reliability, estimates -> targets, tables, page
//! own      recordings of our own model: how probable each is
//! outside    recordings that other programs made: every case by `evpose gap run`, then scored
//! real       recordings of real cameras: names do not depend on how they are looked at
//! calibrate  constants of probabilities and intervals, from rows of a development plan
//! ```

mod args;
mod calibrate;
mod case_files;
mod confusion;
#[cfg(test)]
mod example;
mod group;
mod identification;
mod jsonl;
mod merge;
mod naming;
mod opened;
mod outside;
mod own;
mod page;
mod part;
mod real;
mod row;
mod score;
mod stats;
mod table;
mod tables;
mod targets;
mod truth;

use std::path::Path;

use anyhow::{Context, Result};
use gapbench_pixel::Case;

pub use args::{BenchArgs, CalibrateArgs, ScoreArgs};
use evpose_app::bad_input::BadInput;
use evpose_app::progress::say;
use evpose_app::threads::use_threads;
use evpose_report::gap::files;
use merge::Merged;
pub use outside::{OutsideArgs, run as outside};
use part::PlanId;
pub use real::{RealArgs, run as real};

/// File of the scores.
const SCORES: &str = "scores.json";

/// `evpose gap bench`.
pub fn run(args: &BenchArgs) -> Result<()> {
    use_threads(args.threads)?;
    std::fs::create_dir_all(&args.out)
        .with_context(|| format!("creating {}", args.out.display()))?;
    if let Some(sets) = args.own {
        return own::run(args, sets);
    }
    let plan = PlanId::new(&args.plan, args.tier).context(BadInput)?;
    let cases = part::cases(args, plan).context(BadInput)?;
    if args.cases {
        return naming::write_cases(args, &cases);
    }
    naming::run(args, plan, &cases)?;
    if part::is_whole(&args.shard) {
        let dirs = [args.out.clone()];
        publish(&cases, merge::merge(&dirs, &cases, false)?, plan, &args.out)
    } else {
        say(format!(
            "done; score all parts with `evpose gap score ... --plan {} --tier {}`",
            args.plan,
            plan.tier_name()
        ));
        Ok(())
    }
}

/// `evpose gap score`.
pub fn score(args: &ScoreArgs) -> Result<()> {
    use_threads(args.threads)?;
    let plan = PlanId::new(&args.plan, args.tier).context(BadInput)?;
    let cases = plan.cases();
    let merged = merge::merge(&args.dirs, &cases, args.partial).context(BadInput)?;
    std::fs::create_dir_all(&args.out)
        .with_context(|| format!("creating {}", args.out.display()))?;
    publish(&cases, merged, plan, &args.out)
}

/// `evpose gap calibrate`.
pub fn calibrate(args: &CalibrateArgs) -> Result<()> {
    use_threads(args.threads)?;
    let plan = PlanId::new(&args.plan, args.tier).context(BadInput)?;
    let cases = plan.cases();
    let rows = merge::rows(&args.results, &cases).context(BadInput)?;
    let opened = opened::open(&cases, rows, &Case::label)?;
    calibrate::lines(&opened, plan.seed).iter().for_each(say);
    Ok(())
}

/// Opens the labels of all rows, prints the scores and writes tables and page.
fn publish(cases: &[Case], merged: Merged, plan: PlanId, out: &Path) -> Result<()> {
    say(format!("opening   the labels of {} cases", merged.rows.len()));
    let opened = opened::open(cases, merged.rows, &Case::label)?;
    let scores = score::score_cases(&opened, own::summary(&merged.own), plan);
    table::lines(&scores).iter().for_each(say);
    files::write_json(out, SCORES, &scores)?;
    tables::write(out, &opened, &scores)?;
    files::write(out, page::NAME, page::page(&opened, &scores, &merged.own)?.as_bytes())?;
    say(format!("written to {}", out.display()));
    Ok(())
}
