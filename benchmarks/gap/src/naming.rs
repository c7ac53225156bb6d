//! The naming of cases, a row each: nothing here knows a label.

use std::collections::HashSet;
use std::time::Instant;

use anyhow::{Context, Result};
use gapbench_pixel::Case;

use crate::args::RunArgs;
use crate::bad_input::BadInput;
use crate::case_files::{self, FOLDER};
use crate::part::{Part, PlanId};
use crate::program::Program;
use crate::row::{self, Row};
use crate::terminal::{bar, say, say_above};
use crate::{files, jsonl};

/// A line a case.
pub(super) const RESULTS: &str = "results.jsonl";
/// Folder of what runs of the program leave, a folder a case.
pub(super) const REPORTS: &str = "reports";
/// Seconds a case takes before any was timed.
const SECONDS: f64 = 20.0;

pub(super) fn run(args: &RunArgs, program: &Program, plan: PlanId, cases: &[Case]) -> Result<()> {
    Part::new(plan, cases).claim(&args.out, args.resume).context(BadInput)?;
    let (known, mut results): (Vec<Row>, _) = jsonl::begin(&args.out, RESULTS, args.resume)?;
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
    let progress = bar("naming in", open.len() as u64, "cases");
    for (i, case) in open.iter().enumerate() {
        let begin = Instant::now();
        let folder = args.out.join(FOLDER).join(&case.id);
        let report = args.out.join(REPORTS).join(&case.id);
        case_files::write(&folder, case)?;
        let row = row::name(program, &folder, case, &report, begin.elapsed().as_secs_f64())?;
        // The row is stored before files are removed: an interrupted run repeats one case at most.
        jsonl::append(&mut results, &row)?;
        say_above(&progress, format!("{:>4} {row}", i + 1));
        progress.inc(1);
        if !args.keep {
            files::remove(&folder)?;
            files::remove(&report)?;
        }
    }
    progress.finish_and_clear();
    if !args.keep {
        // Fails where other shards still have cases in it.
        let _ = [FOLDER, REPORTS].map(|name| std::fs::remove_dir(args.out.join(name)));
    }
    Ok(())
}
