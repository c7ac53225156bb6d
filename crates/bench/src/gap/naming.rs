//! The naming of cases, a row each: nothing here knows a label.

use std::collections::HashSet;
use std::io::Write as _;
use std::time::Instant;

use anyhow::{Context, Result};
use gapbench_pixel::Case;

use super::case_files;
use super::jsonl;
use super::part::{Part, PlanId};
use super::row::{self, Row};
use crate::gap::args::BenchArgs;
use evpose_cli::bad_input::BadInput;
use evpose_cli::pages::gap::files;
use evpose_cli::progress::{bar, say};

/// A line a case.
pub(super) const RESULTS: &str = "results.jsonl";
/// Seconds a case takes before any was timed.
const SECONDS: f64 = 20.0;

/// Folder of the files of cases.
const FOLDER: &str = "cases";

/// Writes the files of cases with their ground truth, and identifies nothing.
pub(super) fn write_cases(args: &BenchArgs, cases: &[Case]) -> Result<()> {
    let progress = bar("writing", cases.len() as u64, "cases");
    for case in cases {
        let folder = args.out.join(FOLDER).join(&case.id);
        case_files::write(&folder, case)?;
        files::write_json(&folder, "truth.json", &case.label())?;
        progress.inc(1);
    }
    progress.finish_and_clear();
    say(format!("written to {}", args.out.join(FOLDER).display()));
    Ok(())
}

/// Names in every case that has no row yet.
pub(super) fn run(args: &BenchArgs, plan: PlanId, cases: &[Case]) -> Result<()> {
    Part::new(plan, cases).claim(&args.out, args.resume).context(BadInput)?;
    let path = args.out.join(RESULTS);
    let known: Vec<Row> = if args.resume { jsonl::resume(&path)? } else { Vec::new() };
    if known.is_empty() {
        files::write(&args.out, RESULTS, b"")?;
    }
    let done: HashSet<&str> = known.iter().map(|row| row.id.as_str()).collect();
    let open: Vec<&Case> = cases.iter().filter(|case| !done.contains(case.id.as_str())).collect();
    let each_s = match known.len() {
        0 => SECONDS,
        n => known.iter().map(Row::seconds).sum::<f64>() / n as f64,
    };
    say(format!(
        "budget    {} of {} cases to do at about {each_s:.0} s: {:.0} minutes",
        open.len(),
        cases.len(),
        open.len() as f64 * each_s / 60.0
    ));
    let mut results = std::fs::OpenOptions::new()
        .append(true)
        .open(&path)
        .with_context(|| format!("opening {}", path.display()))?;
    let progress = bar("naming in", open.len() as u64, "cases");
    for (i, case) in open.iter().enumerate() {
        let begin = Instant::now();
        let folder = args.out.join(FOLDER).join(&case.id);
        case_files::write(&folder, case)?;
        let row = row::name(&folder, case, begin.elapsed().as_secs_f64())?;
        // In one piece, so that a run that is cut off leaves whole lines.
        let line = format!("{}\n", serde_json::to_string(&row)?);
        results.write_all(line.as_bytes()).context("writing results.jsonl")?;
        // Lines behind a bar; without a terminal there is none.
        let line = format!("{:>4} {row}", i + 1);
        if progress.is_hidden() {
            say(line);
        } else {
            progress.println(line);
        }
        progress.inc(1);
        if !args.keep {
            std::fs::remove_dir_all(&folder)
                .with_context(|| format!("removing {}", folder.display()))?;
        }
    }
    progress.finish_and_clear();
    if !args.keep {
        // Fails where other shards still have cases in it.
        let _ = std::fs::remove_dir(args.out.join(FOLDER));
    }
    Ok(())
}
