//! Data of a report: written beside the verdict, and read back to draw the page.

mod ablation;
mod plot;
mod plots;
mod probes;
mod side_by_side;

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::GapError;
use crate::locate::Located;
use crate::verdict::Verdict;

pub(crate) use ablation::SECOND_RECORDING;
pub use ablation::{Ablation, CORRECTED_NOTE, Confusability, Doubt, ModelChange};
pub use plot::{AxisScale, Plot};
pub use plots::plots;
pub use probes::{BlockGap, ProbeRow, block_gaps, probe_rows};
pub use side_by_side::{SideBySide, SideBySideFrame};

/// All data of a report. Everything but the verdict may be empty: the page omits empty sections.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReportData {
    /// Answer of the run, as `verdict.json` has it.
    pub verdict: Verdict,
    /// Provenance: recording, scene, model, seed, version, time taken.
    pub provenance: Vec<Fact>,
    /// Gap of each block before and after, see [`block_gaps`].
    pub blocks: Vec<BlockGap>,
    /// All statistics, see [`probe_rows`].
    pub probes: Vec<ProbeRow>,
    /// Location of the disagreement with the model as given.
    pub before: Located,
    /// Location of the disagreement with the corrected model.
    pub after: Option<Located>,
    /// Measured, simulated and corrected curves, see [`plots()`].
    pub plots: Vec<Plot>,
    /// Similarity of effects in this recording.
    pub confusability: Confusability,
    /// Gaps of the ablation: effects added, dropped and swapped.
    pub ablation: Vec<Ablation>,
    /// Measured, simulated and corrected events side by side.
    pub side_by_side: Option<SideBySide>,
    /// Model as given, as TOML.
    pub model_before: String,
    /// Corrected model, as TOML.
    pub model_after: String,
    /// Assumptions, and observations that would overturn the answer; see [`Doubt::for_verdict`].
    pub doubts: Vec<Doubt>,
}

/// A line of provenance.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fact {
    /// Name of the fact.
    pub name: String,
    /// Value of the fact.
    pub value: String,
}

impl Fact {
    /// A fact of this name and value.
    pub fn new(name: impl Into<String>, value: impl Into<String>) -> Self {
        Self { name: name.into(), value: value.into() }
    }
}

impl ReportData {
    /// A report of the verdict alone.
    pub fn from_verdict(verdict: Verdict) -> Self {
        Self {
            doubts: Doubt::for_verdict(&verdict),
            verdict,
            provenance: Vec::new(),
            blocks: Vec::new(),
            probes: Vec::new(),
            before: Located::default(),
            after: None,
            plots: Vec::new(),
            confusability: Confusability::default(),
            ablation: Vec::new(),
            side_by_side: None,
            model_before: String::new(),
            model_after: String::new(),
        }
    }

    /// Serialises to JSON; the same bytes for the same data. Values that are not finite become
    /// `null`.
    ///
    /// # Errors
    /// Data that cannot be serialised.
    pub fn to_json(&self, path: &Path) -> Result<String, GapError> {
        serde_json::to_string(self).map_err(|error| GapError::json(path, error.to_string()))
    }

    /// Parses the output of [`Self::to_json`]; `path` is for the message.
    ///
    /// # Errors
    /// Text that is no report.
    pub fn from_json(text: &str, path: &Path) -> Result<Self, GapError> {
        serde_json::from_str(text).map_err(|error| GapError::json(path, error.to_string()))
    }
}

/// Serialisation of values of which some may be missing: `null` in JSON, NaN in memory.
mod gaps {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(values: &[f64], to: S) -> Result<S::Ok, S::Error> {
        let known: Vec<Option<f64>> =
            values.iter().map(|value| value.is_finite().then_some(*value)).collect();
        known.serialize(to)
    }

    pub(super) fn deserialize<'a, D: Deserializer<'a>>(from: D) -> Result<Vec<f64>, D::Error> {
        let known = Vec::<Option<f64>>::deserialize(from)?;
        Ok(known.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect())
    }
}
