//! Everything that a report shows, as data: written beside the verdict, read back to draw the page.

mod ablation;
mod film;
mod plot;
mod plots;
mod probes;

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::GapError;
use crate::locate::Located;
use crate::verdict::Verdict;

pub(crate) use ablation::SECOND_RECORDING;
pub use ablation::{Ablation, Change, Confusability, Doubt, Ranked};
pub use film::{Film, Frame};
pub use plot::{Plot, Scale};
pub use plots::plots;
pub use probes::{BlockGap, ProbeRow, block_gaps, probe_rows};

/// What a report is drawn from. Everything but the verdict may be left as it is by default: the
/// page leaves out what is empty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReportData {
    /// The answer.
    pub verdict: Verdict,
    /// What was compared, by whom and with what: recording, scene, model, hashes, seed, version,
    /// time taken.
    #[serde(default)]
    pub provenance: Vec<Fact>,
    /// The gap of each block before and after, see [`block_gaps`].
    #[serde(default)]
    pub blocks: Vec<BlockGap>,
    /// Every number that was measured, see [`probe_rows`].
    #[serde(default)]
    pub probes: Vec<ProbeRow>,
    /// Where the model as given disagrees.
    #[serde(default)]
    pub before: Located,
    /// Where the corrected model does.
    #[serde(default)]
    pub after: Option<Located>,
    /// Measured, simulated and corrected curves, see [`plots()`].
    #[serde(default)]
    pub plots: Vec<Plot>,
    /// Every candidate that was tried, the best first.
    #[serde(default)]
    pub candidates: Vec<Ranked>,
    /// The misfit of the model when only its own numbers are refitted: what candidates must beat.
    #[serde(default)]
    pub misfit_without: Option<f64>,
    /// How alike what effects do looks in this recording.
    #[serde(default)]
    pub confusability: Confusability,
    /// The gap with effects added, taken out, and exchanged.
    #[serde(default)]
    pub ablation: Vec<Ablation>,
    /// Measured, simulated and corrected events side by side.
    #[serde(default)]
    pub film: Option<Film>,
    /// The model as given, as TOML.
    #[serde(default)]
    pub model_before: String,
    /// The corrected model, as TOML.
    #[serde(default)]
    pub model_after: String,
    /// What was assumed, and what would overturn the answer; see [`Doubt::of`].
    #[serde(default)]
    pub doubts: Vec<Doubt>,
}

/// A line of provenance.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fact {
    /// What it is about.
    pub name: String,
    /// What it is.
    pub value: String,
}

impl Fact {
    /// A name and a value.
    pub fn new(name: impl Into<String>, value: impl Into<String>) -> Self {
        Self { name: name.into(), value: value.into() }
    }
}

impl ReportData {
    /// A report that shows the verdict and nothing else yet.
    pub fn of(verdict: Verdict) -> Self {
        Self {
            doubts: Doubt::of(&verdict),
            verdict,
            provenance: Vec::new(),
            blocks: Vec::new(),
            probes: Vec::new(),
            before: Located::default(),
            after: None,
            plots: Vec::new(),
            candidates: Vec::new(),
            misfit_without: None,
            confusability: Confusability::default(),
            ablation: Vec::new(),
            film: None,
            model_before: String::new(),
            model_after: String::new(),
        }
    }

    /// As JSON; the same bytes for the same data. Numbers that are not finite become `null`.
    ///
    /// # Errors
    /// Data that JSON cannot hold.
    pub fn to_json(&self, path: &Path) -> Result<String, GapError> {
        serde_json::to_string(self).map_err(|error| GapError::json(path, error.to_string()))
    }

    /// Reads what [`Self::to_json`] made; `path` is for the message.
    ///
    /// # Errors
    /// Text that is no report.
    pub fn from_json(text: &str, path: &Path) -> Result<Self, GapError> {
        serde_json::from_str(text).map_err(|error| GapError::json(path, error.to_string()))
    }
}

/// Numbers of which some may be missing: `null` in JSON, NaN in memory.
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
