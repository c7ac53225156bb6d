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
//! stored   scores and tables again, from stored rows and opened labels
//! calibrate  fit of probabilities and intervals to all stored cases
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
mod stored;
mod table;
mod tables;
mod targets;
mod truth;

use std::path::Path;

use anyhow::{Context, Result};
use gapbench_pixel::Case;

pub use args::{BenchArgs, CalibrateArgs, ScoreArgs};
use evpose_cli::bad_input::BadInput;
use evpose_cli::pages::gap::files;
use evpose_cli::progress::say;
use evpose_cli::threads::use_threads;
use merge::Merged;
use opened::Opened;
pub use outside::{OutsideArgs, run as outside};
use own::OwnRow;
use part::PlanId;
pub use real::{RealArgs, run as real};

/// Files of the scores, and of what is required.
const SCORES: &str = "scores.json";
const TABLE: &str = "table.md";

/// `evpose gap bench`.
pub fn run(args: &BenchArgs) -> Result<()> {
    use_threads(args.threads)?;
    std::fs::create_dir_all(&args.out)
        .with_context(|| format!("creating {}", args.out.display()))?;
    // Runs of our own model choose their cases themselves: nulls of the plan.
    if let Some(sets) = args.own {
        return own::run(args, sets);
    }
    let plan = PlanId::new(&args.plan, args.tier).context(BadInput)?;
    let cases = part::cases(args, plan).context(BadInput)?;
    if args.cases {
        return naming::write_cases(args, &cases);
    }
    naming::run(args, plan, &cases)?;
    // A shard publishes nothing: scores of a part invite conclusions from it.
    if part::is_whole(&args.shard) {
        let dirs = [args.out.clone()];
        let Merged { rows, own } = merge::merge(&dirs, &cases, false)?;
        say(format!("opening   the labels of {} cases", rows.len()));
        let opened = opened::open(plan, &cases, rows, &Case::label)?;
        publish(&opened, &own, Vec::new(), &args.out)
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
    let Some(out) = &args.out else {
        return args.dirs.iter().try_for_each(|root| stored::again(root)).context(BadInput);
    };
    std::fs::create_dir_all(out).with_context(|| format!("creating {}", out.display()))?;
    let Some(plan) = &args.plan else {
        let (opened, own) = stored::cases(&args.dirs).context(BadInput)?;
        return publish(&opened, &own, stored::names(&args.dirs, out), out);
    };
    let plan = PlanId::new(plan, args.tier).context(BadInput)?;
    let cases = plan.cases();
    let Merged { rows, own } = merge::merge(&args.dirs, &cases, args.partial).context(BadInput)?;
    say(format!("opening   the labels of {} cases", rows.len()));
    let opened = opened::open(plan, &cases, rows, &Case::label)?;
    let is_same = args.dirs.contains(out);
    for (name, text) in stored::lines(&opened)? {
        // Rows stay as their program wrote them.
        if !(is_same && name == naming::RESULTS) {
            files::write(out, name, text.as_bytes())?;
        }
    }
    if !(is_same || own.is_empty()) {
        files::write(out, own::NAME, own::text(&own).as_bytes())?;
    }
    publish(&opened, &own, Vec::new(), out)
}

/// `evpose gap calibrate`.
pub fn calibrate(args: &CalibrateArgs) -> Result<()> {
    let fit = calibrate::Fit::of_stored(&args.stored).context(BadInput)?;
    fit.markdown().lines().for_each(say);
    files::write(&args.stored, calibrate::NAME, fit.markdown().as_bytes())?;
    let text = files::json(&fit.calibration)?;
    evpose_core::atomic_write(&args.out, text.as_bytes())
        .with_context(|| format!("writing {}", args.out.display()))?;
    say(format!("written to {}", args.out.display()));
    Ok(())
}

/// Prints the scores of opened cases and writes tables and page.
fn publish(opened: &[Opened], own: &[OwnRow], folders: Vec<String>, out: &Path) -> Result<()> {
    let scores = score::score_cases(opened, own::summary(own), folders);
    table::lines(&scores).iter().for_each(say);
    files::write_json(out, SCORES, &scores)?;
    files::write(out, TABLE, table::markdown(&scores).as_bytes())?;
    tables::write(out, opened, &scores)?;
    files::write(out, page::NAME, page::page(opened, &scores, own)?.as_bytes())?;
    say(format!("written to {}", out.display()));
    Ok(())
}
