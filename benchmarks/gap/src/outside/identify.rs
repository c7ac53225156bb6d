//! The runs of `evpose gap run`, one a case: the time is that of a user from start to report, and a run
//! that ends badly is a result like any other.

use std::collections::HashSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use evpose_gap::run_files;

use super::OutsideArgs;
use super::row::{FAILED, Row, ScoredVerdict};
use crate::naming::{REPORTS, RESULTS};
use crate::program::Program;
use crate::terminal::{bar, say, say_above};
use crate::{files, jsonl};

/// Files of a case that `evpose gap run` reads.
const EVENTS: &str = "events.npz";
const SCENE: &str = "scene.json";

pub(super) fn cases(dir: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(dir).with_context(|| format!("reading {}", dir.display()))?;
    let mut cases = Vec::new();
    for entry in entries {
        let path = entry.with_context(|| format!("reading {}", dir.display()))?.path();
        if path.join(EVENTS).is_file() && path.join(SCENE).is_file() {
            cases.push(path);
        }
    }
    anyhow::ensure!(
        !cases.is_empty(),
        "{}: no folder in it holds {EVENTS} and {SCENE}",
        dir.display()
    );
    // By name, so that shards hold the same cases on every file system.
    cases.sort();
    Ok(cases)
}

/// Name of a case: that of its folder.
pub(super) fn id(case: &Path) -> String {
    case.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Runs every case that has no line yet.
pub(super) fn run(args: &OutsideArgs, cases: &[PathBuf]) -> Result<()> {
    let program = Program::find(&args.program)?;
    let (known, mut results): (Vec<Row>, _) = jsonl::begin(&args.out, RESULTS, args.resume)?;
    let done: HashSet<&str> = known.iter().map(|row| row.id.as_str()).collect();
    let open: Vec<&PathBuf> =
        cases.iter().filter(|case| !done.contains(id(case).as_str())).collect();
    let progress = bar("identifying in", open.len() as u64, "cases");
    for case in open {
        let report = args.out.join(REPORTS).join(id(case));
        let row = identify(args, &program, case, &report)?;
        jsonl::append(&mut results, &row)?;
        say_above(&progress, &row);
        progress.inc(1);
        // The output of a failed run stays, since nothing else says why it failed.
        if !args.keep && row.verdict != FAILED {
            files::remove(&report)?;
        }
    }
    progress.finish_and_clear();
    Ok(())
}

/// Runs one case. A run that ends without a verdict leaves its output in `report`.
fn identify(args: &OutsideArgs, program: &Program, case: &Path, report: &Path) -> Result<Row> {
    let events = case.join(EVENTS);
    let mut arguments: Vec<&OsStr> = vec![OsStr::new("--measured"), events.as_os_str()];
    arguments.extend([OsStr::new("--scene"), case.as_os_str()]);
    arguments.extend(args.options.iter().map(OsStr::new));
    let ended = program.gap_run(&arguments, report)?;
    let (verdict, effects, gap_before, gap_after) = match ended.read(run_files::VERDICT) {
        Ok(ScoredVerdict { verdict, effects, gap_before, gap_after }) => {
            (verdict, effects, gap_before.value, gap_after.value)
        }
        // A crash is a row as well: leaving it out would flatter all rates.
        Err(error) => {
            say(format!("{}: {error:#}", id(case)));
            (FAILED.to_owned(), Vec::new(), None, None)
        }
    };
    Ok(Row {
        id: id(case),
        verdict,
        effects,
        gap_before,
        gap_after,
        seconds: ended.seconds,
        threads: program.threads(),
        options: args.options.clone(),
        commit: program.commit.clone(),
    })
}
