//! Peer programs as shell commands.

use std::path::Path;
use std::process::Command;
use std::str::FromStr;

use anyhow::{Context, Error, Result, ensure};

/// A peer as a shell command: `NAME=COMMAND`.
///
/// It reads the benchmark's files in the folder `$EVPOSE_BENCH` and prints a line for each case
/// that it supports, `CASE: VALUE`, in the unit of the case.
#[derive(Debug, Clone)]
pub struct PeerCommand {
    pub(super) name: String,
    command: String,
}

impl FromStr for PeerCommand {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let (name, command) = text.split_once('=').context("expected NAME=COMMAND")?;
        Ok(Self { name: name.to_owned(), command: command.to_owned() })
    }
}

impl PeerCommand {
    /// Runs the command. Returns the cases and values that it printed.
    pub(super) fn results(&self, folder: &Path) -> Result<Vec<(String, f64)>> {
        let output = Command::new("sh")
            .args(["-c", &self.command])
            .env("EVPOSE_BENCH", folder)
            .output()
            .with_context(|| format!("running the peer {}", self.name))?;
        let errors = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.success(), "the peer {} failed: {}", self.name, errors.trim());
        let text = String::from_utf8_lossy(&output.stdout);
        // Other output of a peer is skipped: runtimes like to print banners.
        let results = text.lines().filter_map(|line| {
            let (case, value) = line.rsplit_once(':')?;
            Some((case.trim().to_owned(), value.trim().parse().ok()?))
        });
        Ok(results.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_lines_of_a_case_and_a_value() {
        let peer: PeerCommand =
            "two=echo a line; echo lnes update: 4.5; echo x: y".parse().unwrap();
        assert_eq!(peer.results(Path::new(".")).unwrap(), [("lnes update".to_owned(), 4.5)]);
        let peer: PeerCommand = "bad=echo gone >&2; false".parse().unwrap();
        assert!(peer.results(Path::new(".")).unwrap_err().to_string().ends_with("failed: gone"));
    }
}
