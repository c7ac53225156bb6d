//! Distances before and after a change of a simulator, against those between its runs.

use std::fmt;

use evpose_core::EventStream;
use serde::Serialize;

use crate::Distance;

/// Standard deviations of the distances between runs within which a distance is chance.
const CHANCE: f64 = 3.0;
/// Minimum decrease of a distance that is significant, standard errors.
const CLEAR: f64 = 2.0;

/// Mean and standard deviation of distances over runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub sd: f64,
    /// Number of distances.
    pub n: usize,
}

impl Spread {
    pub(crate) fn from_distances(distances: &[f64]) -> Self {
        let n = distances.len();
        let mean = distances.iter().sum::<f64>() / n as f64;
        let squares: f64 = distances.iter().map(|d| (d - mean).powi(2)).sum();
        Self { mean, sd: (squares / (n.max(2) - 1) as f64).sqrt(), n }
    }

    /// Whether a mean distance is consistent with this distribution of distances between runs.
    fn covers(&self, distance: f64) -> bool {
        // Equal distances differ by rounding errors.
        distance <= self.mean + CHANCE * self.sd + 1e-12
    }

    fn squared_error(&self) -> f64 {
        self.sd * self.sd / self.n as f64
    }
}

/// Evaluation by one statistic.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Name of the statistic.
    pub name: &'static str,
    /// Unit of its distances; empty for dimensionless ones.
    pub unit: &'static str,
    /// Distances from the recording to the simulator before.
    pub before: Spread,
    /// Distances from the recording to the simulator after.
    pub after: Spread,
    /// Distances between runs of the simulator before.
    pub chance_before: Spread,
    /// Distances between runs of the simulator after.
    pub chance_after: Spread,
    /// Whether the distance has decreased significantly; none if it is consistent with distances
    /// between runs after, and was so before or did not decrease.
    pub came_closer: Option<bool>,
    /// Whether the distance after is consistent with distances between runs.
    pub is_closed: bool,
}

impl Row {
    pub(crate) fn new(
        name: &'static str,
        unit: &'static str,
        distance: &Distance<'_>,
        measured: &EventStream,
        before: &[EventStream],
        after: &[EventStream],
    ) -> Self {
        let to = |runs: &[EventStream]| {
            Spread::from_distances(
                &runs.iter().map(|run| distance(measured, run)).collect::<Vec<_>>(),
            )
        };
        let within = |runs: &[EventStream]| {
            let pairs = (0..runs.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
            Spread::from_distances(
                &pairs.map(|(i, j)| distance(&runs[i], &runs[j])).collect::<Vec<_>>(),
            )
        };
        let (chance_before, chance_after) = (within(before), within(after));
        let (before, after) = (to(before), to(after));
        let is_closed = chance_after.covers(after.mean);
        let error = (before.squared_error() + after.squared_error()).sqrt();
        let has_shrunk = before.mean - after.mean > CLEAR * error;
        let came_closer = match (chance_before.covers(before.mean), is_closed) {
            (true, true) => None,
            // Hardly beyond chance before, and chance after: no evidence either way.
            (false, true) if !has_shrunk => None,
            _ => Some(has_shrunk),
        };
        Self { name, unit, before, after, chance_before, chance_after, came_closer, is_closed }
    }
}

/// Summary of all statistics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EvaluationVerdict {
    /// All distances are chance, before and after.
    Chance,
    /// All significant distances have decreased.
    Closer,
    /// Some have decreased, some have not.
    Partly,
    /// None has decreased.
    NotCloser,
}

/// Result of an evaluation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evaluation {
    /// Rows, one per statistic.
    pub rows: Vec<Row>,
    /// Summary of all rows.
    pub verdict: EvaluationVerdict,
}

impl Evaluation {
    pub(crate) fn from_rows(rows: Vec<Row>) -> Self {
        let any = |answer| rows.iter().any(|row| row.came_closer == Some(answer));
        let verdict = match (any(true), any(false)) {
            (false, false) => EvaluationVerdict::Chance,
            (true, false) => EvaluationVerdict::Closer,
            (true, true) => EvaluationVerdict::Partly,
            (false, true) => EvaluationVerdict::NotCloser,
        };
        Self { rows, verdict }
    }
}

impl fmt::Display for EvaluationVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Chance => "as close as chance before and after",
            Self::Closer => "closer in all that differed",
            Self::Partly => "closer in a part of what differed",
            Self::NotCloser => "not closer",
        })
    }
}

impl fmt::Display for Evaluation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<22}{:>18}{:>18}{:>18}  {:<8}",
            "distance", "before", "after", "of runs", "closer"
        )?;
        for row in &self.rows {
            let name = if row.unit.is_empty() {
                row.name.to_owned()
            } else {
                format!("{}, {}", row.name, row.unit)
            };
            let spread = |s: &Spread| format!("{:.3} +- {:.3}", s.mean, s.sd);
            let closer = match (row.came_closer, row.is_closed) {
                (None, _) => "chance",
                (Some(true), true) => "closed",
                (Some(true), false) => "yes",
                (Some(false), _) => "no",
            };
            let (before, after) = (spread(&row.before), spread(&row.after));
            let chance = spread(&row.chance_after);
            writeln!(f, "{name:<22}{before:>18}{after:>18}{chance:>18}  {closer}")?;
        }
        write!(f, "{}", self.verdict)
    }
}
