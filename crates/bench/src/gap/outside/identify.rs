//! The runs of `evpose gap run`, one a case, each as a process of its own: the time is that of a
//! user from start to report, and a run that ends badly is a result like any other.

use std::collections::HashSet;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context, Result};

use super::OutsideArgs;
use super::row::{FAILED, Row, ScoredVerdict};
use crate::gap::jsonl;
use crate::gap::naming::RESULTS;
use evpose_cli::pages::gap::files;
use evpose_cli::progress::{bar, say};
use evpose_cli::run_info::COMMIT;

/// Files of a case that `evpose gap run` reads.
const EVENTS: &str = "events.npz";
const SCENE: &str = "scene.json";

/// Folders of cases, by name.
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
    let path = args.out.join(RESULTS);
    let known: Vec<Row> = if args.resume { jsonl::resume(&path)? } else { Vec::new() };
    if known.is_empty() {
        files::write(&args.out, RESULTS, b"")?;
    }
    let done: HashSet<&str> = known.iter().map(|row| row.id.as_str()).collect();
    let open: Vec<&PathBuf> =
        cases.iter().filter(|case| !done.contains(id(case).as_str())).collect();
    let mut results = std::fs::OpenOptions::new()
        .append(true)
        .open(&path)
        .with_context(|| format!("opening {}", path.display()))?;
    let progress = bar("identifying in", open.len() as u64, "cases");
    for case in open {
        let report = args.out.join("reports").join(id(case));
        let row = identify(args, case, &report)?;
        // In one piece, so that a run that is cut off leaves whole lines.
        let line = format!("{}\n", serde_json::to_string(&row)?);
        results.write_all(line.as_bytes()).context("writing results.jsonl")?;
        if progress.is_hidden() {
            say(&row);
        } else {
            progress.println(row.to_string());
        }
        progress.inc(1);
        if !args.keep && row.verdict != FAILED {
            std::fs::remove_dir_all(&report)
                .with_context(|| format!("removing {}", report.display()))?;
        }
    }
    progress.finish_and_clear();
    Ok(())
}

/// Runs one case. A process that ends without a verdict leaves its output in `report`.
fn identify(args: &OutsideArgs, case: &Path, report: &Path) -> Result<Row> {
    // A verdict of an earlier run must not pass for that of this one.
    if report.exists() {
        std::fs::remove_dir_all(report)
            .with_context(|| format!("removing {}", report.display()))?;
    }
    std::fs::create_dir_all(report).with_context(|| format!("creating {}", report.display()))?;
    let output = report.join("output.txt");
    let file = File::create(&output).with_context(|| format!("creating {}", output.display()))?;
    // Both streams go to one file, in the order in which they were written.
    let errors = file.try_clone().context("sharing the output file")?;
    let mut command = Command::new(std::env::current_exe().context("path of this program")?);
    command.args(["gap", "run", "--model", "ideal", "--measured"]).arg(case.join(EVENTS));
    command.arg("--scene").arg(case).arg("--out").arg(report).args(&args.options);
    if let Some(threads) = args.threads {
        command.arg("--threads").arg(threads.to_string());
    }
    // From start to exit, as users wait for it.
    let begin = Instant::now();
    let status = command.stdin(Stdio::null()).stdout(file).stderr(errors).status();
    let seconds = begin.elapsed().as_secs_f64();
    let status = status.context("starting `evpose gap run`")?;
    let verdict = ScoredVerdict::read(&report.join(files::VERDICT));
    let (verdict, effects, gap_before, gap_after) = match verdict {
        Ok(verdict) => {
            let (before, after) = (verdict.gap_before.value, verdict.gap_after.value);
            (verdict.verdict, verdict.effects, before, after)
        }
        // A crash is a row as well: leaving it out would flatter all rates.
        Err(error) => {
            say(format!("{}: {status}, {error}; see {}", id(case), output.display()));
            (FAILED.to_owned(), Vec::new(), None, None)
        }
    };
    Ok(Row {
        id: id(case),
        verdict,
        effects,
        gap_before,
        gap_after,
        seconds,
        threads: args.threads.unwrap_or_else(rayon::current_num_threads),
        options: args.options.clone(),
        commit: COMMIT.to_owned(),
    })
}
