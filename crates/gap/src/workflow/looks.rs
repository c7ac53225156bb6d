//! Comparison where the light of a scene is not known in full: several looks of it are.
//!
//! # Method
//! The numbers that are compared are measured on events of the model before each look. How far they
//! differ from those before the scene that is taken for the true one is what nobody knows of the
//! recording: differences up to three times that do not count. Thresholds differ between looks as
//! well, since contrast and threshold are one thing where light was not measured. Numbers that say
//! what a change of light is worth are not compared at all, and effects that the unknown part of the
//! scene can do as well are not looked for.

use evpose_core::{CounterRng, seed_for};
use evpose_sensor::SensorConfig;

use super::inputs::{Inputs, Prepared};
use super::spread::Spread;
use crate::naming::Named;
use crate::parameters::Parameter;
use crate::verdict::{Answer, FindingKind, Verdict};
use crate::{Block, GapError, Layout, Scene, View};

/// Other looks that are tried.
const LOOKS: u64 = 8;
/// Thresholds are up to this further apart, as a logarithm.
const THRESHOLD_SPREAD: f64 = 0.2;

/// What is not known of a scene, and what is therefore left open.
#[derive(Debug)]
pub struct Unknown {
    /// What is said of such a comparison.
    pub note: &'static str,
    /// Effects that it can do as well, and why they are not to be told.
    pub like: &'static [(&'static str, &'static str)],
    /// Why thresholds are no finding.
    pub thresholds: &'static str,
    /// What is said where thresholds would have been one.
    pub instead_of_thresholds: &'static str,
    /// Whether it says which pixels are at rest, so that a fit may begin with their background. Where
    /// texture is made up, faint motion passes for rest, and such a fit for an explanation.
    pub begins_at_rest: bool,
    /// What is said before the place where recording and model disagree.
    pub place: &'static str,
}

/// The scene with look number `i`.
pub type Look<'a> = &'a dyn Fn(u64) -> Result<Scene, GapError>;

impl Prepared {
    /// As [`Prepared::new`] where the scenes are one of many looks: `train` and `held` give others.
    /// Without a second recording, looks of the only one serve for both.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene, and looks that cannot be had.
    pub fn of_looks(
        mut inputs: Inputs,
        unknown: &Unknown,
        train: Look<'_>,
        held: Option<Look<'_>>,
    ) -> Result<Self, GapError> {
        inputs.left_out.extend(unknown.like.iter().map(|(name, _)| (*name).to_owned()));
        let mut prepared = Self::new(inputs)?;
        let mut layout =
            Layout::of_blocks(|block| !matches!(block, Block::Crossing | Block::Swing));
        let seed = seed_for(prepared.seed, "looks", 0);
        let model = &prepared.model.config;
        let parts = [&prepared.screen, &prepared.train, &prepared.held];
        let mut spread = Spread::of(&layout, LOOKS);
        let mut own = Vec::new();
        for (case, stage) in parts {
            let events = stage.scene.events(model, seed)?;
            own.push(layout.summarise(&View::new(stage, &events, case.window)));
        }
        for i in 0..LOOKS {
            let other = with_other_thresholds(model, &mut CounterRng::new(seed, "thresholds", i));
            let of_train = train(i)?.events(&other, seed)?;
            let of_held = held.map(|held| held(i)?.events(&other, seed)).transpose()?;
            for (k, (case, stage)) in parts.into_iter().enumerate() {
                let events = if k == 2 { of_held.as_ref().unwrap_or(&of_train) } else { &of_train };
                let look = layout.summarise(&View::new(stage, events, case.window));
                spread.add(k, &layout, &own[k], &look);
            }
        }
        spread.widen(&mut layout);
        prepared.layout = layout;
        prepared.begins_at_rest = unknown.begins_at_rest;
        prepared.notes.insert(0, unknown.note.to_owned());
        Ok(prepared)
    }
}

fn with_other_thresholds(model: &SensorConfig, rng: &mut CounterRng) -> SensorConfig {
    let factor = rng.uniform(-THRESHOLD_SPREAD as f32, THRESHOLD_SPREAD as f32);
    let mut model = model.clone();
    for threshold in [Parameter::ThresholdOn, Parameter::ThresholdOff] {
        let value = threshold.value(&model);
        if value > 0.0 {
            threshold.set(&mut model, value * f64::from(factor).exp());
        }
    }
    model
}

impl Unknown {
    /// Leaves of a verdict what can be said although this is not known: thresholds are no findings, and
    /// what was not looked for is said.
    pub fn restrict(&self, verdict: &mut Verdict) {
        let is_threshold = |name: &str| name == "threshold_on" || name == "threshold_off";
        let before = verdict.effects.len();
        verdict
            .effects
            .retain(|finding| finding.kind == FindingKind::Effect || !is_threshold(&finding.name));
        if verdict.effects.len() < before {
            verdict.notes.insert(1, self.instead_of_thresholds.to_owned());
        }
        if verdict.verdict == Answer::Parameter && verdict.effects.is_empty() {
            // A model whose thresholds are free has no gap.
            verdict.verdict = Answer::NoGap;
            verdict.gap_before = verdict.gap_after;
            verdict.grr = 0.0;
        }
        // Both see light and texture, whatever they are.
        (verdict.c2st_before, verdict.c2st_after) = (None, None);
        if !verdict.place.sentence.is_empty() {
            verdict.place.sentence = format!("{}: {}", self.place, verdict.place.sentence);
        }
        let like = self.like.iter().map(|(name, why)| ((*name).to_owned(), (*why).to_owned()));
        verdict.untestable.extend(like);
        let why = self.thresholds.to_owned();
        verdict.untestable.insert("threshold_on, threshold_off".to_owned(), why);
    }

    /// The same of an answer before there is a verdict.
    pub fn restrict_named(&self, named: &mut Named) {
        let is_threshold =
            |p: &Parameter| matches!(p, Parameter::ThresholdOn | Parameter::ThresholdOff);
        named.moved.retain(|parameter| !is_threshold(parameter));
        if named.answer == Answer::Parameter && named.moved.is_empty() {
            named.answer = Answer::NoGap;
        }
    }
}
