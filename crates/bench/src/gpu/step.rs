//! A step in a process of its own.

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use serde::Serialize;
use serde_json::Value;

use super::plan::Step;

/// Interval at which a process is looked after.
const POLL: Duration = Duration::from_millis(20);
/// The last lines of what a process printed that are kept.
const LAST_LINES: usize = 25;
/// And the most characters of a line.
const LONGEST_LINE: usize = 400;

/// Outcome of a step.
#[derive(Debug, Serialize)]
pub(super) struct Finished {
    pub(super) name: &'static str,
    pub(super) device: String,
    /// The way of convolutions on GPUs.
    pub(super) way: &'static str,
    command: String,
    seconds: f64,
    limit_s: f64,
    /// `done`, `failed` or `out of time`.
    outcome: &'static str,
    /// Results by file; a file that was not reached is missing.
    pub(super) results: Vec<Value>,
    /// The end of what it printed.
    last_lines: Vec<String>,
}

impl std::fmt::Display for Finished {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, device, way, seconds, outcome, results, .. } = self;
        write!(f, "{name} {device} {way}: {outcome} in {seconds:.1} s, {} results", results.len())?;
        if *outcome != "done" {
            // What a process prints last says why it failed.
            for line in self.last_lines.iter().rev().take(6).rev() {
                write!(f, "\n         | {line}")?;
            }
        }
        Ok(())
    }
}

impl Step {
    /// Runs the step in the folder `parts`, no longer than its limit and what is `left`.
    ///
    /// # Errors
    /// If no process can be started.
    pub(super) fn run(self, parts: &Path, left: Duration) -> Result<Finished> {
        let limit = Duration::from_secs_f64(self.limit_s).min(left);
        let log = parts.join("log.txt");
        // A full pipe would block the process, which nobody reads while it runs.
        let out = File::create(&log).with_context(|| format!("creating {}", log.display()))?;
        for file in &self.files {
            // Of an earlier run.
            let _ = std::fs::remove_file(parts.join(file));
        }
        let program = std::env::current_exe().context("finding this program")?;
        let started = Instant::now();
        let mut child = Command::new(program)
            .args(&self.arguments)
            // A process reads the way once: another way takes another process.
            .env("EVPOSE_GPU_CONVOLUTION", self.way)
            .envs(self.environment.iter().copied())
            .current_dir(parts)
            .stdin(Stdio::null())
            .stdout(out.try_clone()?)
            .stderr(out)
            .spawn()
            .context("starting a step")?;
        let outcome = loop {
            if let Some(status) = child.try_wait()? {
                break if status.success() { "done" } else { "failed" };
            }
            if started.elapsed() >= limit {
                child.kill()?;
                // It is waited for, so that the next step has the device for itself.
                child.wait()?;
                break "out of time";
            }
            std::thread::sleep(POLL);
        };
        // A file that was cut off when time was over does not parse, and counts as missing.
        let results = self
            .files
            .iter()
            .filter_map(|file| serde_json::from_slice(&std::fs::read(parts.join(file)).ok()?).ok());
        let printed = String::from_utf8_lossy(&std::fs::read(&log)?).into_owned();
        let lines: Vec<&str> = printed.lines().collect();
        let last = lines[lines.len().saturating_sub(self.lines.max(LAST_LINES))..].iter();
        Ok(Finished {
            name: self.name,
            device: self.device,
            way: self.way,
            command: self.arguments.join(" "),
            seconds: started.elapsed().as_secs_f64(),
            limit_s: limit.as_secs_f64(),
            outcome,
            results: results.collect(),
            last_lines: last.map(|line| line.chars().take(LONGEST_LINE).collect()).collect(),
        })
    }
}
