//! Comparison where the light of a scene is not fully known: nuisance parameters are marginalised
//! by sampling.
//!
//! # Method
//! The model is simulated on several samples of the scene, drawn with other nuisance parameters.
//! The standard deviation of each statistic over the samples, against the scene that is compared,
//! is its uncertainty: three of them are tolerated. Thresholds vary between samples as well,
//! because contrast and threshold are degenerate where light was not measured. Statistics of events
//! per change of luminance are excluded, and so are effects that are degenerate with the nuisance
//! parameters.

use evpose_core::{CounterRng, seed_for};
use evpose_sensor::{STAGES, SensorConfig, StageSpec};

use super::inputs::{Inputs, Prepared};
use super::nuisance_spread::NuisanceSpread;
use crate::parameters::ModelParameter;
use crate::search::Identification;
use crate::search_spec::SceneSource;
use crate::search_spec::Searched;
use crate::verdict::{Answer, FindingKind, Verdict};
use crate::{GapError, Layout, LightSequence, StatisticBlock, View};

const SAMPLES: u64 = 8;
/// Range of the thresholds of samples, as a logarithm to either side.
const THRESHOLD_SPREAD: f64 = 0.2;

/// Nuisance parameters of a scene, and their consequences for the verdict.
#[derive(Debug)]
pub struct Nuisance {
    /// Note on such a comparison.
    pub note: &'static str,
    /// Source of the scene. The catalogue says which effects are degenerate with the nuisance
    /// parameters of such scenes.
    pub source: SceneSource,
    /// Reason for which thresholds are no finding.
    pub thresholds: &'static str,
    /// Note in the place of a finding of thresholds.
    pub instead_of_thresholds: &'static str,
    /// Whether pixels at rest are known, so that a fit may start from their background rates. With
    /// a synthetic texture, faint motion looks like rest, and such a fit like an explanation.
    pub begins_at_rest: bool,
    /// Prefix of the description of the location.
    pub place: &'static str,
}

/// Draws the scene with sample `i` of the nuisance parameters.
pub type NuisanceSample<'a> = &'a dyn Fn(u64) -> Result<LightSequence, GapError>;

impl Prepared {
    /// As [`Prepared::new`], with nuisance parameters whose samples are drawn by `train` and
    /// `held_out`. Without a second recording, samples of the only one serve for both.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene, and samples that cannot be drawn.
    pub fn with_nuisance(
        mut inputs: Inputs,
        nuisance: &Nuisance,
        train: NuisanceSample<'_>,
        held_out: Option<NuisanceSample<'_>>,
    ) -> Result<Self, GapError> {
        let degenerate = nuisance.degenerate();
        inputs.left_out.extend(degenerate.map(|(name, _)| name.to_owned()));
        let mut prepared = Self::new(inputs)?;
        // These blocks compare events with the exact light, which a guessed scene does not have.
        let mut layout = Layout::of_blocks(|block| {
            !matches!(block, StatisticBlock::Crossing | StatisticBlock::LogIntensityStep)
        });
        let seed = seed_for(prepared.seed, "looks", 0);
        let model = &prepared.model.config;
        let parts = [&prepared.screen, &prepared.train, &prepared.held_out];
        let mut spread = NuisanceSpread::new(&layout, SAMPLES);
        let mut own = Vec::new();
        for (case, reference_scene) in parts {
            let events = reference_scene.scene.events(model, seed)?;
            own.push(layout.summarise(&View::new(reference_scene, &events, case.window)));
        }
        // The scatter over what is not known widens tolerances: a statistic that depends on it
        // decides less.
        for i in 0..SAMPLES {
            let other = with_other_thresholds(model, &mut CounterRng::new(seed, "thresholds", i));
            let of_train = train(i)?.events(&other, seed)?;
            let of_held_out =
                held_out.map(|held_out| held_out(i)?.events(&other, seed)).transpose()?;
            for (k, (case, reference_scene)) in parts.into_iter().enumerate() {
                let events =
                    if k == 2 { of_held_out.as_ref().unwrap_or(&of_train) } else { &of_train };
                let sample = layout.summarise(&View::new(reference_scene, events, case.window));
                spread.add(k, &layout, &own[k], &sample);
            }
        }
        spread.widen(&mut layout);
        prepared.layout = layout;
        prepared.begins_at_rest = nuisance.begins_at_rest;
        prepared.notes.insert(0, nuisance.note.to_owned());
        Ok(prepared)
    }
}

fn with_other_thresholds(model: &SensorConfig, rng: &mut CounterRng) -> SensorConfig {
    // One factor for both: what a guessed scene leaves open is its contrast.
    let factor = rng.uniform(-THRESHOLD_SPREAD as f32, THRESHOLD_SPREAD as f32);
    let mut model = model.clone();
    for threshold in [ModelParameter::ThresholdOn, ModelParameter::ThresholdOff] {
        let value = threshold.value(&model);
        if value > 0.0 {
            threshold.set(&mut model, value * f64::from(factor).exp());
        }
    }
    model
}

impl Nuisance {
    /// Effects of the catalogue that are degenerate with the nuisance parameters, with the reason.
    pub fn degenerate(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        let source = self.source;
        let reason = move |spec: &&StageSpec| Some((spec.name, spec.search().hidden_by(source)?));
        STAGES.entries().iter().filter_map(reason)
    }

    /// Restricts a verdict to what the nuisance parameters leave open: thresholds are no findings,
    /// and degenerate effects are listed as untestable.
    pub fn restrict(&self, verdict: &mut Verdict) {
        let is_threshold = |name: &str| name == "threshold_on" || name == "threshold_off";
        let before = verdict.effects.len();
        verdict
            .effects
            .retain(|finding| finding.kind == FindingKind::Effect || !is_threshold(&finding.name));
        if verdict.effects.len() < before {
            verdict.notes.insert(1, self.instead_of_thresholds.to_owned());
        }
        let is_empty = verdict.effects.is_empty() && verdict.demoted.is_empty();
        if verdict.verdict == Answer::Parameter && is_empty {
            // With free thresholds, the model has no gap.
            verdict.verdict = Answer::NoGap;
            verdict.gap_before = verdict.gap_after;
            verdict.grr = 0.0;
        }
        // The classifier sees the nuisance parameters themselves.
        (verdict.c2st_before, verdict.c2st_after) = (None, None);
        if !verdict.place.sentence.is_empty() {
            verdict.place.sentence = format!("{}: {}", self.place, verdict.place.sentence);
        }
        let degenerate = self.degenerate();
        verdict.untestable.extend(degenerate.map(|(name, why)| (name.to_owned(), why.to_owned())));
        let why = self.thresholds.to_owned();
        verdict.untestable.insert("threshold_on, threshold_off".to_owned(), why);
    }

    /// Restricts the result of a search in the same way.
    pub fn restrict_identification(&self, identification: &mut Identification) {
        let is_threshold = |p: &ModelParameter| {
            matches!(p, ModelParameter::ThresholdOn | ModelParameter::ThresholdOff)
        };
        // Thresholds and the contrast of a guessed scene are one thing.
        identification.changed_parameters.retain(|changed| !is_threshold(&changed.parameter));
        if identification.answer == Answer::Parameter
            && identification.changed_parameters.is_empty()
        {
            identification.answer = Answer::NoGap;
        }
    }
}
