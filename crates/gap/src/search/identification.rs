//! The data that a search works on, and its result.

use evpose_sensor::{SensorConfig, Stage};

use super::budget::Budget;
use super::formula_terms::FORMULA;
use super::selection::Selection;
use crate::candidate::Trial;
use crate::fit::Fit;
use crate::parameters::ModelParameter;
use crate::verdict::{Answer, SignatureTest};
use crate::{GapError, Objective};

/// Simulated runs by which a model is scored.
pub(super) const SCORE_RUNS: u64 = 4;

/// The data splits of a search, each with its objective.
#[derive(Debug)]
pub struct DataSplits<'a> {
    /// A short part of the training data, for screening.
    pub screen: Objective<'a>,
    /// The training data that models are fitted to.
    pub train: Objective<'a>,
    /// The held-out data that models are scored on.
    pub held_out: Objective<'a>,
    /// Time below which nothing is compared, microseconds: the frames of a scene on whose grid the
    /// time stamps lie; zero if they do not.
    pub resolution_us: f64,
    /// Time that the search may take; none if it ends by itself.
    pub budget: Option<Budget>,
}

impl DataSplits<'_> {
    /// Whether times that are strengths of a selection's effects are not below the resolution.
    pub(super) fn resolves(&self, selection: &Selection) -> bool {
        selection.effects.iter().all(|effect| {
            let strength = effect.candidate.trial.params[0];
            let value = selection.model.effect(effect.candidate.name);
            let value = value.and_then(|effect| effect.number(strength.name));
            strength.unit != "us" || value.is_none_or(|us| us.abs() >= self.resolution_us)
        })
    }

    pub(super) fn score(&self, model: &SensorConfig) -> Result<ModelScore, GapError> {
        let (discrepancy, gap) = self.held_out.score(model, SCORE_RUNS)?;
        Ok(ModelScore { model: model.clone(), discrepancy, gap })
    }
}

/// A model with its scores on held-out data.
#[derive(Debug, Clone)]
pub struct ModelScore {
    /// Sensor model that was scored.
    pub model: SensorConfig,
    /// Its discrepancy statistic, see [`crate::discrepancy`].
    pub discrepancy: f64,
    /// Its gap, see [`crate::gap()`].
    pub gap: f64,
}

/// A candidate effect fitted to the training data.
#[derive(Debug, Clone)]
pub struct FittedCandidate {
    /// Name of the effect in the catalogue.
    pub name: &'static str,
    /// The model with the effect.
    pub fit: Fit,
    /// The effect's variant with the parameters that were fitted.
    pub trial: Trial,
}

impl FittedCandidate {
    /// Whether it serves the pixels one after the other, or line by line.
    pub(super) fn is_readout(&self) -> bool {
        matches!(self.trial.spec.typical_stage(), Ok(Stage::Readout(_)))
    }
}

/// A fitted candidate with its scores on held-out data.
#[derive(Debug, Clone)]
pub struct Contender {
    /// Effect with its fitted parameters.
    pub candidate: FittedCandidate,
    /// Scores of the model with it.
    pub held_out: ModelScore,
}

/// Fractions of the gap that an effect or a parameter explains on held-out data.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ExplainedFraction {
    /// Alone, added to the model as given (add-one).
    pub alone: f64,
    /// Beside all others, dropped from the corrected model (drop-one).
    pub beside_others: f64,
    /// Probability of as much if the model without it were true, from replicates.
    pub p: f64,
    /// Losses that it adds beside all others, as a fraction of those that it removes: the sums of
    /// the losses of statistics that rise and of those that fall. A missing effect makes hardly
    /// anything worse.
    pub worsened: f64,
}

/// A parameter of the model that differs from its given value.
#[derive(Debug, Clone, PartialEq)]
pub struct ChangedParameter {
    /// Parameter of the sensor model.
    pub parameter: ModelParameter,
    /// Fractions of the gap that the change explains.
    pub explained: ExplainedFraction,
    /// Whether the recording shows what the parameter does; none without a test.
    pub test: Option<SignatureTest>,
}

impl ChangedParameter {
    /// Whether the parameter failed its test.
    pub fn is_demoted(&self) -> bool {
        self.test.as_ref().is_some_and(|test| !test.passes)
    }
}

/// Unexplained part of the gap on held-out data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Left {
    /// Fraction of the gap as given.
    pub fraction: f64,
    /// Probability that a run of the corrected model deviates as much, from replicates.
    pub p: f64,
    /// Whether it is significant.
    pub is_significant: bool,
}

/// An effect that was added to the model, and the contenders that it was selected from.
#[derive(Debug, Clone)]
pub struct AddedEffect {
    /// All contenders that were scored, the best first.
    pub contenders: Vec<Contender>,
    /// Names of contenders that do as well as the best.
    pub confusable: Vec<&'static str>,
    /// Discrepancy of the model without the effect, the others fitted again.
    pub discrepancy_without: f64,
    /// The model without the effect, the others fitted again.
    pub model_without: SensorConfig,
    /// Fractions of the gap that it explains.
    pub explained: ExplainedFraction,
    /// Whether the recording shows what the effect does; none without a test.
    pub test: Option<SignatureTest>,
}

impl AddedEffect {
    /// Whether the name failed its test.
    pub fn is_demoted(&self) -> bool {
        self.test.as_ref().is_some_and(|test| !test.passes)
    }

    /// Whether it has a name: no formula, and no failed test.
    pub fn is_named(&self) -> bool {
        self.name() != FORMULA && !self.is_demoted()
    }

    /// Name of the effect in the catalogue.
    pub fn name(&self) -> &'static str {
        self.contenders[0].candidate.name
    }
}

/// Result of a search.
#[derive(Debug, Clone)]
pub struct Identification {
    /// Kind of the answer.
    pub answer: Answer,
    /// Scores of the model as given.
    pub before: ModelScore,
    /// Scores of the model with its own parameters refitted.
    pub refitted: ModelScore,
    /// Effects, those that explain most first.
    pub added_effects: Vec<AddedEffect>,
    /// Scores of the corrected model.
    pub after: ModelScore,
    /// Parameters of the model that differ significantly from the given ones.
    pub changed_parameters: Vec<ChangedParameter>,
    /// Part of the gap that the corrected model leaves.
    pub left: Left,
    /// Whether the search ended because its time was over.
    pub is_cut: bool,
}
