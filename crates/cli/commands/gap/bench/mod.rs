//! `evpose gap bench`: effects hidden in recordings of an independent pixel, and what is found.
//!
//! Every case is written as the files of a measurement, without its label; what is named is named
//! from those files. Labels are opened when all cases of the shard are done.

mod case_files;
mod row;
mod score;
mod table;
mod truth;

use std::collections::HashSet;
use std::io::Write as _;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use gapbench_pixel::{Case, Plan};

use super::args::BenchArgs;
use super::{BadInput, files};
use crate::commands::use_threads;
use crate::progress::{bar, say};
use row::Row;

/// A line a case.
const RESULTS: &str = "results.jsonl";
/// What comes of all of them.
const SCORES: &str = "scores.json";
/// Seconds a case takes before any was timed.
const SECONDS: f64 = 20.0;

pub(super) fn run(args: &BenchArgs) -> Result<()> {
    use_threads(args.threads)?;
    let cases = cases(args).context(BadInput)?;
    std::fs::create_dir_all(&args.out)
        .with_context(|| format!("creating {}", args.out.display()))?;
    let path = args.out.join(RESULTS);
    let known = if args.resume { row::read(&path)? } else { Vec::new() };
    if !args.resume {
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
        let folder = args.out.join("cases").join(&case.id);
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
        let _ = std::fs::remove_dir(args.out.join("cases"));
    }
    let rows = row::read(&path)?;
    let mine: HashSet<&str> = cases.iter().map(|case| case.id.as_str()).collect();
    let rows: Vec<&Row> = rows.iter().filter(|row| mine.contains(row.id.as_str())).collect();
    say(format!("opening   the labels of {} cases", rows.len()));
    let scores = score::of(&cases, &rows);
    table::lines(&scores).iter().for_each(say);
    files::write_json(&args.out, SCORES, &scores)?;
    say(format!("written to {}", args.out.display()));
    Ok(())
}

/// The cases of the shard.
fn cases(args: &BenchArgs) -> Result<Vec<Case>> {
    let seed = seed(&args.plan)?;
    let (part, parts) = args
        .shard
        .split_once('/')
        .and_then(|(i, n)| Some((i.parse::<usize>().ok()?, n.parse::<usize>().ok()?)))
        .filter(|(i, n)| (1..=*n).contains(i))
        .with_context(|| format!("--shard {}: expected I/N, for example 1/4", args.shard))?;
    let kind = |case: &Case| serde_json::to_value(case.kind).unwrap_or_default();
    let is_wanted = |case: &Case| {
        args.only.is_empty() || args.only.iter().any(|only| kind(case).as_str() == Some(only))
    };
    let cases = Plan::from_seed(seed).into_iter().filter(is_wanted);
    let of_shard = cases.skip(part - 1).step_by(parts);
    let cases: Vec<Case> = of_shard.take(args.limit.unwrap_or(usize::MAX)).collect();
    ensure!(!cases.is_empty(), "no case of the plan is left");
    Ok(cases)
}

/// The seed that was typed, or that of a file.
fn seed(plan: &str) -> Result<u64> {
    if let Ok(seed) = plan.parse() {
        return Ok(seed);
    }
    let text = std::fs::read_to_string(plan)
        .with_context(|| format!("--plan {plan}: neither a seed nor a file"))?;
    let table: toml::Table = text.parse().with_context(|| plan.to_owned())?;
    let seed = table.get("seed").and_then(toml::Value::as_integer);
    seed.and_then(|seed| u64::try_from(seed).ok())
        .with_context(|| format!("{plan}: no line `seed = N`"))
}
