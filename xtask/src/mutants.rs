//! `cargo xtask mutants`: whether the tests of the small crates fail where the code is wrong.
//!
//! cargo-mutants replaces one operator, value or body at a time, and a test of the same crate has to
//! fail. It changes files in place, so that little is built again: run it in a clone. The page is
//! made of the newest result of each mutant.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail};
use evpose_core::stats::interval::wilson;
use serde_json::Value;

const CRATES: [&str; 6] = ["core", "pose", "repr", "clean", "camera", "gap-eval"];
/// Share of the mutants that tests must kill, in percent.
const GOAL: f64 = 85.0;
const PAGE: &str = "benches/mutants.md";
/// On each line `crate: mutant without its place | why it is left`.
const REASONS: &str = include_str!("mutants/reasons.txt");
/// Results, by crate and run.
const RUNS: &str = "target/mutants";
const COMMAND: &str = "mutants --in-place --no-times --package";

/// Tries mutants of a crate, with `k/n` every `n`-th one from the `k`-th on, with `again` those that
/// were not killed; then, and without a crate, writes the page.
///
/// # Errors
/// If cargo-mutants is missing or the tests fail as they are, the tree has changes, or a crate is
/// below the goal.
pub(crate) fn run(args: &[String], say: fn(&str)) -> Result<()> {
    if let [name, part @ ..] = args {
        if !Command::new("git").args(["diff", "--quiet", "HEAD"]).status()?.success() {
            bail!("files are changed in place: commit yours first");
        }
        let part = part.first().map_or("0/1", String::as_str);
        // A folder for every run: the results of the others stay.
        let run = fs::read_dir(Path::new(RUNS).join(name)).map_or(0, Iterator::count);
        let folder = format!("{RUNS}/{name}/{run}-{}", part.replace('/', "-of-"));
        fs::create_dir_all(&folder)?;
        let mut command = cargo(&format!("{COMMAND} evpose-{name} --output {folder}"));
        if part == "again" {
            let known = outcomes(name)?.0.into_iter();
            for (mutant, _) in known.filter(|(_, is)| is == "MissedMutant" || is == "Timeout") {
                command.args(["--re", &format!("^{}$", regex::escape(&mutant))]);
            }
        } else {
            command.args(["--sharding=round-robin", "--shard", part]);
        }
        // 2 and 3: mutants that survived or took too long.
        match command.status().context("cargo-mutants: `cargo install cargo-mutants`")?.code() {
            Some(0 | 2 | 3) => {}
            code => bail!("cargo mutants ended with {code:?}"),
        }
    }
    let (mut table, mut left, mut below) = (String::new(), String::new(), Vec::new());
    for name in CRATES {
        let (outcomes, all) = outcomes(name)?;
        let count = |kind: &str| outcomes.values().filter(|summary| *summary == kind).count();
        let [caught, timeout, unviable, missed] =
            ["CaughtMutant", "Timeout", "Unviable", "MissedMutant"].map(count);
        let (killed, tried) = (caught + timeout, caught + timeout + missed);
        let score = 100.0 * killed as f64 / tried as f64;
        if score < GOAL {
            below.push(name);
        }
        if tried == 0 {
            writeln!(table, "| `{name}` | {all} | 0 | | | | | | not tried yet |")?;
            below.push(name);
            continue;
        }
        let (low, high) = wilson(killed, tried);
        // The interval says what a sample leaves open, and a crate that was tried whole has none.
        let interval = match outcomes.len() < all {
            true => format!("{:.0} to {:.0} %", 100.0 * low, 100.0 * high),
            false => "all were tried".to_owned(),
        };
        let counts = format!("{all} | {tried} | {killed} | {timeout} | {unviable} | {missed}");
        writeln!(table, "| `{name}` | {counts} | {score:.1} % | {interval} |")?;
        for (mutant, _) in outcomes.iter().filter(|(_, summary)| *summary == "MissedMutant") {
            let place = mutant.trim_start_matches(&format!("crates/{name}/src/"));
            let place = place.replace('|', "\\|");
            writeln!(left, "| `{name}` | `{place}` | {} |", reason(name, mutant))?;
        }
    }
    let version = String::from_utf8(cargo("mutants --version").output()?.stdout)?;
    let text = include_str!("mutants/page.md")
        .replace("VERSION", version.trim())
        .replace("GOAL", &GOAL.to_string())
        .replace("COMMAND", COMMAND);
    fs::write(PAGE, text.replace("TABLE\n", &table).replace("LEFT\n", &left))?;
    say(&format!("{PAGE} is written"));
    if below.is_empty() { Ok(()) } else { bail!("below {GOAL} %: {}", below.join(", ")) }
}

fn cargo(line: &str) -> Command {
    let mut cargo = Command::new("cargo");
    cargo.args(line.split(' '));
    cargo
}

/// Newest results of the mutants of a crate, and how many mutants there are.
fn outcomes(name: &str) -> Result<(BTreeMap<String, String>, usize)> {
    let list = cargo(&format!("mutants --list --package evpose-{name}")).output()?.stdout;
    let list = String::from_utf8(list)?;
    let runs = fs::read_dir(Path::new(RUNS).join(name)).into_iter().flatten().flatten();
    let results = runs.map(|run| run.path().join("mutants.out/outcomes.json"));
    let mut results: Vec<_> = results.filter(|path| path.is_file()).collect();
    // Oldest first: newer results replace them.
    results.sort_by_key(|path| path.metadata().and_then(|data| data.modified()).ok());
    let mut newest = BTreeMap::new();
    for path in results {
        let run: Value = serde_json::from_slice(&fs::read(&path)?)?;
        for outcome in run["outcomes"].as_array().into_iter().flatten() {
            let mutant = outcome["scenario"]["Mutant"]["name"].as_str().unwrap_or_default();
            // Others are mutants of code that has changed since.
            if list.lines().any(|listed| listed == mutant) {
                let summary = outcome["summary"].as_str().unwrap_or_default();
                newest.insert(mutant.to_owned(), summary.to_owned());
            }
        }
    }
    Ok((newest, list.lines().count()))
}

fn reason(name: &str, mutant: &str) -> &'static str {
    let text = mutant.splitn(4, ':').last().unwrap_or_default().trim();
    let mut reasons = REASONS.lines().filter_map(|line| line.split_once(" | "));
    reasons.find(|(of, _)| of.split_once(": ") == Some((name, text))).map_or("no test yet", |r| r.1)
}
