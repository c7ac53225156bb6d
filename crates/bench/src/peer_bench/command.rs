//! Programs of others, as the user has them.

use std::path::Path;
use std::process::Command;
use std::str::FromStr;

use anyhow::{Context, Error, Result, ensure};

/// A shell command that does the work of a benchmark's cases: `NAME=COMMAND`.
///
/// It finds the benchmark's files in the folder `$EVPOSE_BENCH` and prints a line for each case that
/// it knows, `CASE: FIGURE`, in the benchmark's own unit.
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
    /// Cases and figures that it printed.
    pub(super) fn figures(&self, folder: &Path) -> Result<Vec<(String, f64)>> {
        let output = Command::new("sh")
            .args(["-c", &self.command])
            .env("EVPOSE_BENCH", folder)
            .output()
            .with_context(|| format!("running the peer {}", self.name))?;
        let errors = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.success(), "the peer {} failed: {}", self.name, errors.trim());
        let text = String::from_utf8_lossy(&output.stdout);
        let figures = text.lines().filter_map(|line| {
            let (case, figure) = line.rsplit_once(':')?;
            Some((case.trim().to_owned(), figure.trim().parse().ok()?))
        });
        Ok(figures.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_lines_with_a_number_behind_a_colon() {
        let peer: PeerCommand =
            "two=echo a line; echo lnes update: 4.5; echo x: y".parse().unwrap();
        assert_eq!(peer.figures(Path::new(".")).unwrap(), [("lnes update".to_owned(), 4.5)]);
        let peer: PeerCommand = "bad=echo gone >&2; false".parse().unwrap();
        assert!(peer.figures(Path::new(".")).unwrap_err().to_string().ends_with("failed: gone"));
    }
}
