//! Runs steps one after the other, and sums up.

use std::io::{BufRead, BufReader};
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, bail, ensure};

use crate::steps::Step;
use crate::totals::Totals;

/// No crate of this name may be in the output of `cargo tree`.
const REFUSED: &str = "evpose";

/// The steps that run.
#[derive(Debug, Default)]
pub(crate) struct Choice {
    /// Those with this text in their reason.
    only: Option<String>,
    /// From this one on, counted from 1.
    from: usize,
    /// None: they are listed.
    pub(crate) is_list: bool,
}

impl Choice {
    /// Reads `--only TEXT`, `--from N` and `--list`.
    ///
    /// # Errors
    /// If there is anything else.
    pub(crate) fn parse(args: &[String]) -> Result<Self> {
        let mut choice = Self::default();
        let mut args = args.iter();
        while let Some(arg) = args.next() {
            match arg.as_str() {
                "--only" => choice.only = Some(args.next().context("--only TEXT")?.clone()),
                "--from" => choice.from = args.next().context("--from N")?.parse()?,
                "--list" => choice.is_list = true,
                other => bail!("{other}: not --only TEXT, --from N or --list"),
            }
        }
        Ok(choice)
    }

    /// The chosen steps, counted from 1.
    fn of<'a>(&self, steps: &'a [Step]) -> Vec<(usize, &'a Step)> {
        let is_chosen = |(number, step): &(usize, &Step)| {
            let only = self.only.as_deref().unwrap_or_default();
            *number >= self.from && step.why.contains(only)
        };
        (1..).zip(steps).filter(is_chosen).collect()
    }
}

/// Runs the chosen steps, those after one that failed too. The last line is the total of all tests;
/// before it are the steps with their times, and what failed or was ignored.
pub(crate) fn run(steps: &[Step], choice: &Choice, say: fn(&str)) -> ExitCode {
    let chosen = choice.of(steps);
    if choice.is_list || chosen.is_empty() {
        for (number, step) in &chosen {
            say(&format!("{number:2}  {} (cargo {})", step.why, step.cargo));
        }
        if chosen.is_empty() {
            say("no step is of that name");
            return ExitCode::FAILURE;
        }
        return ExitCode::SUCCESS;
    }
    let (mut totals, mut summary) = (Totals::default(), Vec::new());
    let (mut has_failed, all) = (false, Instant::now());
    for (number, step) in chosen {
        let name = format!("{number}/{} {}", steps.len(), step.why);
        if let Some(reason) = step.need.as_ref().and_then(|need| need.missing()) {
            say(&format!("== {name}: not run, {reason}"));
            summary.push(format!("not run            {name}: {reason}"));
            continue;
        }
        say(&format!("== {name} (cargo {})", step.cargo));
        let started = Instant::now();
        let mut of_step = Totals::default();
        let result = run_step(step, &mut of_step, say);
        let seconds = started.elapsed().as_secs_f64();
        let (word, reason) = match result {
            Ok(()) => ("passed", String::new()),
            Err(error) => {
                has_failed = true;
                // Without a test that failed, the step counts as one.
                of_step.failed = of_step.failed.max(1);
                ("FAILED", format!(": {error:#}"))
            }
        };
        say(&format!("== {word}, {seconds:.0} s{reason}"));
        summary.push(format!("{word} {seconds:7.0} s   {name}{reason}"));
        totals.add_step(of_step, step.runs_ignored());
    }
    for (name, reason) in &totals.ignored_tests {
        say(&format!("ignored: {name}{}{reason}", if reason.is_empty() { "" } else { ": " }));
    }
    for name in &totals.failed_tests {
        say(&format!("failed: {name}"));
    }
    for line in &summary {
        say(line);
    }
    say(&format!("{:.0} s in all", all.elapsed().as_secs_f64()));
    let Totals { passed, failed, ignored, .. } = totals;
    say(&format!("{passed} passed, {failed} failed, {ignored} skipped"));
    if has_failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// Runs one step, passing its output on and counting the tests in it.
fn run_step(step: &Step, totals: &mut Totals, say: fn(&str)) -> Result<()> {
    let args: Vec<&str> = step.cargo.split_whitespace().collect();
    // Another toolchain is chosen by what rustup puts in front of cargo.
    let is_chosen = args[0].starts_with('+');
    let cargo = std::env::var("CARGO").ok().filter(|_| !is_chosen);
    let mut child = Command::new(cargo.unwrap_or_else(|| "cargo".into()))
        .args(&args)
        .envs(step.env.iter().copied())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .context("starting cargo")?;
    let output = child.stdout.take().context("cargo's output")?;
    let mut is_any_refused = false;
    // Lines are split as bytes, since a test may print what is not UTF-8.
    for line in BufReader::new(output).split(b'\n') {
        let line = line.context("reading cargo's output")?;
        let line = String::from_utf8_lossy(&line);
        totals.add_line(&line);
        is_any_refused |= is_refused(&args, &line);
        say(&line);
    }
    let status = child.wait()?;
    ensure!(status.success(), "cargo ended with {status}");
    ensure!(!is_any_refused, "no crate called {REFUSED}* may be in it");
    // Cargo passes where a filter matches nothing: a renamed test would never run again.
    ensure!(!args.contains(&"test") || !totals.is_empty(), "there is no such test");
    Ok(())
}

/// Whether a line of `cargo tree --prefix none` names a crate that must not be there.
fn is_refused(args: &[&str], line: &str) -> bool {
    args.first() == Some(&"tree") && line.starts_with(REFUSED)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::steps::SLOW;

    #[test]
    fn trees_may_not_hold_crates_of_the_simulator() {
        let tree = ["tree", "--package=gapbench-pixel"];
        assert!(is_refused(&tree, "evpose-sensor v0.1.0 (/here/evpose/crates/sensor)"));
        assert!(!is_refused(&tree, "gapbench-pixel v0.1.0 (/here/evpose/benchmarks/gap/pixel)"));
        assert!(!is_refused(&["test"], "evpose-sensor v0.1.0"));
    }

    #[test]
    fn steps_are_chosen_by_number_and_by_text() {
        let indices = |args: &[&str]| -> Vec<usize> {
            let args: Vec<String> = args.iter().map(|arg| (*arg).to_owned()).collect();
            let chosen = Choice::parse(&args).expect("a choice");
            chosen.of(SLOW).into_iter().map(|(number, _)| number).collect()
        };
        let last = SLOW.len();
        assert_eq!(indices(&[]), (1..=last).collect::<Vec<_>>());
        assert_eq!(indices(&["--from", &last.to_string()]), [last]);
        assert_eq!(indices(&["--only", "fuzz targets"]), [1]);
        assert!(indices(&["--only", "fuzz targets", "--from", "2"]).is_empty());
        assert!(Choice::parse(&["--form".to_owned()]).is_err());
    }
}
