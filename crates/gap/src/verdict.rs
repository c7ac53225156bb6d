//! The verdict of the workflow, as data: `verdict.json`.

use serde::{Deserialize, Serialize};

/// Schema version of [`Verdict`].
pub const SCHEMA: u32 = 4;

/// The answer of the workflow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// The model explains the recording.
    NoGap,
    /// A parameter of the model has a wrong value.
    Parameter,
    /// Effects of the catalogue are missing.
    Effects,
    /// Effects of the catalogue or parameters explain a part of the gap; the rest is significant.
    Partial,
    /// There is a gap, of which no effect of the catalogue explains anything significant.
    NoneOfCatalogue,
    /// There is a gap, and the recording does not determine its cause.
    Undecided,
}

impl Answer {
    /// Exit code of the command.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::NoGap => 0,
            Self::Parameter => 10,
            Self::Effects => 11,
            Self::NoneOfCatalogue => 12,
            Self::Undecided => 13,
            Self::Partial => 14,
        }
    }

    /// The answer in one word, as `verdict.json` has it.
    pub fn key(self) -> &'static str {
        match self {
            Self::NoGap => "no_gap",
            Self::Parameter => "parameter",
            Self::Effects => "effects",
            Self::Partial => "partial",
            Self::NoneOfCatalogue => "none_of_catalogue",
            Self::Undecided => "undecided",
        }
    }
}

/// Whether a finding is a missing effect or a wrong parameter of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FindingKind {
    /// An effect of the catalogue.
    Effect,
    /// A parameter of the model.
    Parameter,
    /// A formula for what no effect of the catalogue explains.
    Formula,
}

/// An estimate with its 90 % interval.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Quantity {
    /// Best value.
    pub value: f64,
    /// Lower end of the interval.
    pub lo90: f64,
    /// Upper end of the interval.
    pub hi90: f64,
    /// Unit; empty for a dimensionless quantity.
    pub unit: String,
    /// Values in the first and the second half of a recording, where halves are compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub halves: Option<[f64; 2]>,
}

/// A missing effect or a wrong parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Name in the catalogue.
    pub name: String,
    /// Effect or parameter.
    pub kind: FindingKind,
    /// Estimates of its parameters, by name.
    pub parameters: std::collections::BTreeMap<String, Quantity>,
    /// Of an effect: probability that the identification is right, as a fit to cases whose truth is
    /// known has it (`gapbench calibrate`); without a scene, that it is not chance. None of a
    /// parameter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probability: Option<f64>,
    /// Effects that this recording does not distinguish from it.
    pub confusable_with: Vec<String>,
    /// Whether the recording shows what the effect does and its relatives do not; none of an effect
    /// without such a test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signature: Option<SignatureTest>,
    /// Fractions of the gap that it explains; none where there is no gap to explain, without a scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub explained: Option<Explained>,
    /// Of a formula: the formula itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub formula: Option<FoundFormula>,
}

/// A formula that explains what no effect of the catalogue does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoundFormula {
    /// Stage that it acts at, as the effect `formula` takes it.
    pub stage: String,
    /// The formula with its values.
    pub expression: String,
    /// Variable along which the curve is drawn; empty for a constant.
    pub variable: String,
    /// Values of the variable, and of the formula there.
    pub curve: Vec<[f64; 2]>,
    /// A possible cause, in words.
    pub reading: String,
}

impl Finding {
    /// Whether its name failed its test: it explains, but is not it.
    pub fn is_demoted(&self) -> bool {
        self.signature.as_ref().is_some_and(|test| !test.passes)
    }
}

/// Test of a name by the signature of its effect: what the recording would have to show.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SignatureTest {
    /// Whether the name stands.
    pub passes: bool,
    /// Probability of as clear a signature if the best model without the effect were true; one where
    /// the recording does not show it.
    pub p: f64,
    /// The sign that the recording would have to show, behind "it would have to".
    pub must: String,
    /// Its values: measured, with the effect, and without it.
    pub shows: String,
    /// A recording that would show it.
    pub recording: String,
}

/// Fractions of the gap as given that an effect or a parameter explains, on held-out data.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Explained {
    /// Alone, added to the model as given (add-one).
    pub alone: f64,
    /// Beside all others, dropped from the corrected model (drop-one).
    pub beside_others: f64,
    /// Probability of as much if the model without it were true, from replicates on this scene.
    pub p: f64,
}

/// A gap with its 90 % interval; one is the gap of another run of the model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GapValue {
    /// Value of the gap.
    #[serde(deserialize_with = "or_unknown")]
    pub value: f64,
    /// Lower end.
    #[serde(deserialize_with = "or_unknown")]
    pub lo: f64,
    /// Upper end.
    #[serde(deserialize_with = "or_unknown")]
    pub hi: f64,
}

/// The part of the gap that the corrected model leaves unexplained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Unexplained {
    /// Fraction of the gap as given that is left on held-out data.
    #[serde(deserialize_with = "or_unknown")]
    pub fraction: f64,
    /// Probability that a run of the corrected model deviates as much, from replicates.
    #[serde(deserialize_with = "or_unknown")]
    pub p: f64,
    /// Whether it is significant: a probability below .01, and a gap of more than 1, which two runs of
    /// one model have.
    pub is_significant: bool,
    /// Domain of the signal chain whose effects explain most of it.
    pub nearest_stage: String,
    /// Location in image, time and light, as a sentence.
    pub sentence: String,
    /// Fraction of what is left that each axis explains: brightness, speed, age, polarity, place,
    /// time.
    pub shares: std::collections::BTreeMap<String, f64>,
    /// Excess or deficit as a fitted function of light, its change, time and place, in words; the
    /// law that describes most first.
    pub responses: Vec<String>,
}

/// Location of the disagreement of measured and simulated events.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Location {
    /// Description as a sentence.
    pub sentence: String,
    /// Fraction of the disagreement that each axis explains: brightness, speed, age, polarity,
    /// place, time.
    pub shares: std::collections::BTreeMap<String, f64>,
}

/// Detection limit of an effect in this recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// Name of the effect.
    pub name: String,
    /// Parameter that is the effect's strength.
    pub parameter: String,
    /// Smallest detectable value.
    pub value: f64,
    /// Unit of the value.
    pub unit: String,
}

/// Result of a classifier two-sample test on patches of measured and simulated events.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TwoSample {
    /// Area under the ROC curve; one half is chance.
    pub auc: f64,
    /// p-value of a permutation test.
    pub p: f64,
}

/// The complete verdict; the same bytes for the same inputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Schema version.
    pub schema: u32,
    /// Kind of the answer.
    pub verdict: Answer,
    /// Missing effects and wrong parameters, those that explain most first.
    pub effects: Vec<Finding>,
    /// Names that explain a part of the gap, but failed their tests.
    #[serde(default)]
    pub demoted: Vec<Finding>,
    /// The part of the gap that is left.
    pub unexplained: Unexplained,
    /// Gap of the model as given, on held-out data.
    pub gap_before: GapValue,
    /// Gap of the corrected model, on held-out data.
    pub gap_after: GapValue,
    /// Gap closed (fraction): one minus what is left unexplained.
    #[serde(deserialize_with = "or_unknown")]
    pub grr: f64,
    /// p-value of the largest deviation over all statistics.
    pub p: f64,
    /// Location of the disagreement.
    #[serde(rename = "where")]
    pub place: Location,
    /// Fraction of the gap as given by domain: of what is named, and of what is left where that is
    /// significant.
    pub stage_shares: std::collections::BTreeMap<String, f64>,
    /// Detection limits.
    pub limits: Vec<Limit>,
    /// Effects that are not testable in this recording, with the reason.
    pub untestable: std::collections::BTreeMap<String, String>,
    /// Two-sample test of the model as given; none where it was not made.
    pub c2st_before: Option<TwoSample>,
    /// Two-sample test of the corrected model.
    pub c2st_after: Option<TwoSample>,
    /// Corrections of the input: unit and start of its stamps, mirrored image, inverted polarity.
    #[serde(default)]
    pub corrections: Vec<String>,
    /// Whether the search ended because its time was over.
    #[serde(default)]
    pub is_out_of_time: bool,
    /// The next step, as a sentence.
    #[serde(default)]
    pub next: String,
    /// Unusual properties of the inputs, and assumptions.
    pub notes: Vec<String>,
}

/// Exit code where the search ended because its time was over, whatever was found until then.
pub const OUT_OF_TIME: u8 = 15;

impl Verdict {
    /// Exit code of the command.
    pub fn exit_code(&self) -> u8 {
        if self.is_out_of_time { OUT_OF_TIME } else { self.verdict.exit_code() }
    }

    /// Whether it was made without a scene, in which case there is no gap.
    pub fn is_scene_free(&self) -> bool {
        self.gap_before.value.is_nan()
    }
}

/// Reads `null`, which is how JSON holds an unknown value, as NaN.
fn or_unknown<'a, D: serde::Deserializer<'a>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::NAN))
}
