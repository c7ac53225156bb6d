//! Scores of a network, recording by recording, as sums that can be resampled.

use evpose_core::stats::bootstrap::Totals;
use serde::Serialize;

/// A metric of a task's evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Metric {
    /// Field in JSON files.
    pub key: &'static str,
    /// Heading in tables, with the unit.
    pub heading: &'static str,
    /// Digits behind the point.
    pub digits: usize,
    /// Whether smaller values are better.
    pub is_error: bool,
}

/// Scores of one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingScores {
    /// Name of its file, without the extension.
    pub recording: String,
    /// For each metric, in their order, the sum and count of its values: of each joint, or of all
    /// together.
    pub totals: Vec<Vec<Totals>>,
}

/// Scores of a network on every recording of a directory.
#[derive(Debug, Clone, PartialEq)]
pub struct EvaluationScores {
    /// The task's metrics, the main one first.
    pub metrics: &'static [Metric],
    /// One per recording, in the order of their names.
    pub recordings: Vec<RecordingScores>,
}
