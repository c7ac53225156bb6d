//! One case as a line of results: the verdict of `evpose gap run`, and its time.

use std::collections::BTreeMap;
use std::fmt;

use evpose_gap::verdict::FindingKind;
use serde::{Deserialize, Serialize};

/// The verdict of a case. Nothing in it comes from the truth.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Row {
    /// The case: the name of its folder.
    pub(super) id: String,
    /// The answer, as `verdict.json` has it; `failed` where the run ended without one.
    pub(super) verdict: String,
    /// Effects and parameters of the verdict, in its order.
    pub(super) effects: Vec<NamedFinding>,
    /// Gap of the model as given and of the corrected one; none where it is unknown.
    pub(super) gap_before: Option<f64>,
    pub(crate) gap_after: Option<f64>,
    /// Seconds from start to report.
    pub(super) seconds: f64,
    pub(super) threads: usize,
    pub(super) options: Vec<String>,
    pub(crate) commit: String,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct NamedFinding {
    pub(super) name: String,
    pub(super) kind: FindingKind,
    /// Stated probability; none where there is none.
    #[serde(default)]
    pub(super) probability: Option<f64>,
    #[serde(default)]
    pub(super) parameters: BTreeMap<String, Value>,
}

/// Value of a parameter; none where it is unknown.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Value {
    pub(super) value: Option<f64>,
}

/// Fields of `verdict.json` that are scored; the others are not read, whatever its schema.
#[derive(Debug, Deserialize)]
pub(super) struct ScoredVerdict {
    pub(super) verdict: String,
    pub(super) effects: Vec<NamedFinding>,
    pub(super) gap_before: Gap,
    pub(super) gap_after: Gap,
}

#[derive(Debug, Deserialize)]
pub(super) struct Gap {
    pub(super) value: Option<f64>,
}

/// The answer of a run that ended without a verdict.
pub(super) const FAILED: &str = "failed";

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.effects.iter().map(|finding| finding.name.as_str()).collect();
        let gap = |gap: Option<f64>| gap.map_or_else(|| "-".to_owned(), |gap| format!("{gap:.2}"));
        write!(
            f,
            "{:<10}{:<18}gap {:>6} to {:<6}{:>7.1} s  {}",
            self.id,
            self.verdict,
            gap(self.gap_before),
            gap(self.gap_after),
            self.seconds,
            names.join(" + ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_of_later_schemas_are_skipped() -> serde_json::Result<()> {
        let verdict: ScoredVerdict = serde_json::from_str(
            r#"{"schema": 9, "verdict": "partial", "effects": [{"name": "leak_on", "kind": "effect",
               "parameters": {"rate_hz": {"value": 2.5, "lo90": 2.0, "hi90": 3.0, "unit": "Hz"}},
               "probability": 0.9, "explained_alone": 0.4}],
               "unexplained": {"fraction": 0.2}, "gap_before": {"value": 9.5, "lo": 9.0, "hi": 10.0},
               "gap_after": {"value": null}}"#,
        )?;
        assert_eq!((verdict.verdict.as_str(), verdict.gap_after.value), ("partial", None));
        assert!(verdict.gap_before.value.is_some_and(|gap| (gap - 9.5).abs() < 1e-12));
        let [finding] = verdict.effects.as_slice() else { panic!("{:?}", verdict.effects) };
        assert_eq!(finding.parameters["rate_hz"].value, Some(2.5));
        assert_eq!(finding.kind, FindingKind::Effect);
        Ok(())
    }
}
