//! What the workflow says in the end, as data.

use serde::{Deserialize, Serialize};

/// The version of the form of [`Verdict`].
pub const SCHEMA: u32 = 1;

/// The answer in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// The model explains the recording.
    NoGap,
    /// A number of the model was set wrong.
    Parameter,
    /// Effects of the catalogue are missing.
    Effects,
    /// Something is missing that the catalogue does not hold.
    NoneOfCatalogue,
    /// There is a gap, and nothing that can be said of it with confidence.
    Undecided,
}

impl Answer {
    /// The exit code of the command.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::NoGap => 0,
            Self::Parameter => 10,
            Self::Effects => 11,
            Self::NoneOfCatalogue => 12,
            Self::Undecided => 13,
        }
    }
}

/// Whether a finding is an effect or a number that the model has anyway.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FindingKind {
    /// An effect of the catalogue.
    Effect,
    /// A number of the model.
    Parameter,
}

/// A number with its interval of 90 %.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Quantity {
    /// The best value.
    pub value: f64,
    /// Lower end of the interval.
    pub lo90: f64,
    /// Upper end of the interval.
    pub hi90: f64,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// In the first half of a recording and in the second, where halves are compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub halves: Option<[f64; 2]>,
}

/// One thing that is missing or set wrong.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// The name in the catalogue.
    pub name: String,
    /// Effect or parameter.
    pub kind: FindingKind,
    /// Its numbers.
    pub parameters: std::collections::BTreeMap<String, Quantity>,
    /// How probable it is that this is the right name.
    pub probability: f64,
    /// What cannot be told from it in this recording.
    pub confusable_with: Vec<String>,
}

/// A gap with its interval of 90 %; one cannot be told from a fresh run of the model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GapValue {
    /// The gap.
    #[serde(deserialize_with = "or_unknown")]
    pub value: f64,
    /// Lower end.
    #[serde(deserialize_with = "or_unknown")]
    pub lo: f64,
    /// Upper end.
    #[serde(deserialize_with = "or_unknown")]
    pub hi: f64,
}

/// What is left unexplained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Remaining {
    /// Whether it matters.
    pub is_significant: bool,
    /// The domain of the chain that is nearest to it.
    pub nearest_stage: String,
    /// The part of the image, of time and of light that it is in.
    pub sentence: String,
}

/// Where measured and simulated events disagree.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Where {
    /// In words.
    pub sentence: String,
    /// Share of the disagreement along each axis: brightness, speed, age, polarity, place, time.
    pub shares: std::collections::BTreeMap<String, f64>,
}

/// The least strength of an effect that this recording would show.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// The effect.
    pub name: String,
    /// The number that makes it strong.
    pub parameter: String,
    /// The least value that shows.
    pub value: f64,
    /// Its unit.
    pub unit: String,
}

/// How well a classifier tells patches of measured from patches of simulated events.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TwoSample {
    /// Area under the curve; one half is chance.
    pub auc: f64,
    /// Probability of such a value by chance.
    pub p: f64,
}

/// The whole answer; the same bytes for the same inputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// The version of this form.
    pub schema: u32,
    /// The answer in one word.
    pub verdict: Answer,
    /// What is missing or set wrong, the most important first.
    pub effects: Vec<Finding>,
    /// What is left.
    pub remaining: Remaining,
    /// The gap of the model as given, on what was held out.
    pub gap_before: GapValue,
    /// The gap of the corrected model there.
    pub gap_after: GapValue,
    /// One less the ratio of what is above one, after and before.
    #[serde(deserialize_with = "or_unknown")]
    pub grr: f64,
    /// Probability of the largest deviation by chance, all probes together.
    pub p: f64,
    /// Where they disagree.
    #[serde(rename = "where")]
    pub place: Where,
    /// Share of the disagreement that the effects of each domain span.
    pub stage_shares: std::collections::BTreeMap<String, f64>,
    /// What would have been seen.
    pub limits: Vec<Limit>,
    /// Effects that this recording says nothing about, with the reason.
    pub untestable: std::collections::BTreeMap<String, String>,
    /// The classifier check before; none where it was not made.
    pub c2st_before: Option<TwoSample>,
    /// The classifier check after.
    pub c2st_after: Option<TwoSample>,
    /// What was found to be unusual about the inputs, and what was assumed.
    pub notes: Vec<String>,
}

impl Verdict {
    /// Whether it is of a recording alone: without a scene there is no gap.
    pub fn is_bare(&self) -> bool {
        self.gap_before.value.is_nan()
    }
}

/// A number that may be `null`, which is what JSON makes of one that is not known.
fn or_unknown<'a, D: serde::Deserializer<'a>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::NAN))
}
