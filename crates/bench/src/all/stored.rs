//! The figures of a run as a file, and what changed since another.

use std::path::Path;

use anyhow::{Context, Result};
use evpose_cli::provenance::Provenance;
use serde::{Deserialize, Serialize};

use super::figure::Figure;
use super::limits::MachineLimits;

/// Relative change below which figures count as equal: the noise of an idle machine.
const NOISE: f64 = 0.1;

/// A run of all benchmarks on one machine.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct StoredRun {
    #[serde(flatten)]
    pub(crate) provenance: Provenance,
    pub(crate) limits: Vec<MachineLimits>,
    pub(crate) figures: Vec<Figure>,
}

impl StoredRun {
    /// Reads a run that `--json` wrote.
    ///
    /// # Errors
    /// If the file cannot be read or is no such file.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path)
            .with_context(|| format!("reading the figures in {}", path.display()))?;
        serde_json::from_str(&text).with_context(|| {
            format!("{}: not the figures that `evpose bench all --json` writes", path.display())
        })
    }

    /// Speed relative to the same figure of an earlier run.
    pub(crate) fn speed_over(before: &Self, figure: &Figure) -> Option<f64> {
        let before = before.figures.iter().find(|other| other.is_same_work(figure))?;
        Some(figure.speed_over(before.value))
    }
}

/// Figures that became faster or slower, as lines.
pub(crate) fn changes(run: &StoredRun, before: &StoredRun) -> Vec<String> {
    let mut lines = Vec::new();
    // Differences between machines are no changes of the program, but still of interest.
    if run.provenance.machine != before.provenance.machine {
        lines.push(format!(
            "warning   the earlier figures are of another machine: {}, {} threads",
            before.provenance.machine.cpu, before.provenance.machine.threads
        ));
    }
    let mut changed = 0;
    for figure in &run.figures {
        let Some(speed) = StoredRun::speed_over(before, figure) else { continue };
        if (speed - 1.0).abs() > NOISE {
            changed += 1;
            let word = if speed < 1.0 { "slower" } else { "faster" };
            lines.push(format!(
                "{word:9} {:.2} times as fast as before: {}, {} ({:.3} {})",
                speed, figure.benchmark, figure.work, figure.value, figure.unit
            ));
        }
    }
    if changed == 0 {
        lines.push("no figure changed by more than 10 %".to_owned());
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(value: f64) -> StoredRun {
        let figures = vec![Figure::time("infer", "a network", "ms", value)];
        StoredRun { provenance: Provenance::this(), limits: Vec::new(), figures }
    }

    #[test]
    fn a_slower_figure_is_listed_and_noise_is_not() {
        assert_eq!(changes(&run(1.05), &run(1.0)), ["no figure changed by more than 10 %"]);
        let lines = changes(&run(2.0), &run(1.0));
        assert!(lines[0].starts_with("slower") && lines[0].contains("0.50 times"), "{lines:?}");
        let mut other = run(1.0);
        other.provenance.machine.cpu = "another".into();
        assert!(changes(&run(1.0), &other)[0].starts_with("warning"));
    }
}
