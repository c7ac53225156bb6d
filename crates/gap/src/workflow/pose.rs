//! Comparison where only the poses of what was seen are known: light and texture are made up.
//!
//! # Method
//! The scene is rendered at the known poses with one look, and again with others: other skin, lights,
//! background and arm, and thresholds up to a fifth away, since contrast and threshold are one
//! thing where no light was measured. How far the numbers of those differ from those of the first is
//! what nobody knows of the recording: differences up to three times that do not count. Numbers
//! that say what a change of light is worth are not compared at all, and effects that texture can
//! do as well are not looked for.

use evpose_core::{CounterRng, seed_for};
use evpose_sensor::SensorConfig;

use super::inputs::{Inputs, Prepared};
use crate::parameters::Parameter;
use crate::verdict::{Answer, FindingKind, Verdict};
use crate::{Block, GapError, Kind, Layout, Scene, View};

/// Other looks that are tried.
const LOOKS: u64 = 8;
/// Standard deviations between looks that do not count.
const TOLERATED: f64 = 3.0;
/// Numbers that looks move by more than this, as a share of all events or as a multiple of what
/// does not matter anyway, say nothing here and are not compared.
const LARGEST_SHARE: f64 = 0.05;
const LARGEST_MULTIPLE: f64 = 20.0;
/// Thresholds are up to this further apart, as a logarithm.
const THRESHOLD_SPREAD: f64 = 0.2;

/// Effects that a texture or a light can do as well, and what it takes to tell.
pub const LIKE_TEXTURE: [(&str, &str); 8] = [
    ("tone_curve", "contrast of the texture and tone curve are one thing"),
    ("quantisation", "steps of the tone curve and texture are one thing"),
    ("dark_current", "dark current and faint texture in the dark are one thing"),
    ("veiling_glare", "glare and faint texture are one thing"),
    ("vignetting", "vignetting and fall-off of the light are one thing"),
    ("psf_blur", "blur and coarse texture are one thing"),
    ("lateral_coupling", "coupling of pixels and fine texture are one thing"),
    ("reset_overshoot", "events lost on an edge and lower contrast are one thing"),
];

/// What is said of such a comparison.
const NOTE: &str = "mode B: poses are known, light and texture are not. Thresholds and everything \
                    that texture can do as well are left open; other differences count where they \
                    are larger than those between looks of the scene";

/// The scene with look number `i`.
pub type Look<'a> = &'a dyn Fn(u64) -> Result<Scene, GapError>;

impl Prepared {
    /// As [`Prepared::new`] where light and texture of the scenes are one of many looks: `train` and
    /// `held` give others. Without a second recording, looks of the only one serve for both.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene, and looks that cannot be had.
    pub fn of_poses(
        mut inputs: Inputs,
        train: Look<'_>,
        held: Option<Look<'_>>,
    ) -> Result<Self, GapError> {
        inputs.left_out.extend(LIKE_TEXTURE.map(|(name, _)| name.to_owned()));
        let mut prepared = Self::new(inputs)?;
        let mut layout =
            Layout::of_blocks(|block| !matches!(block, Block::Crossing | Block::Swing));
        let seed = seed_for(prepared.seed, "looks", 0);
        let model = &prepared.model.config;
        let parts = [&prepared.screen, &prepared.train, &prepared.held];
        let mut spread = Spread::of(&layout);
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
        prepared.notes.insert(0, NOTE.to_owned());
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

/// How much looks differ, number by number, on the scale of its tolerance.
struct Spread {
    /// Sums of squares of the three parts; infinite where a look has no such number.
    squares: [Vec<f64>; 3],
}

impl Spread {
    fn of(layout: &Layout) -> Self {
        Self { squares: [0, 1, 2].map(|_| vec![0.0; layout.entries.len()]) }
    }

    fn add(&mut self, part: usize, layout: &Layout, own: &[f64], look: &[f64]) {
        let events = layout.events(own).max(1.0);
        let number_of = |value: f64| 0.25 * value * value;
        for (i, sum) in self.squares[part].iter_mut().enumerate() {
            let (a, b) = (own[i], look[i]);
            if a.is_nan() && b.is_nan() {
                continue;
            }
            let apart = match layout.entries[i].kind {
                Kind::Count(_) => (number_of(b) - number_of(a)) / events,
                Kind::Number(_) => b - a,
            };
            *sum += if apart.is_finite() { apart * apart } else { f64::INFINITY };
        }
    }

    fn widen(&self, layout: &mut Layout) {
        for (i, entry) in layout.entries.iter_mut().enumerate() {
            let most = self.squares.iter().map(|part| part[i]).fold(0.0, f64::max);
            let apart = TOLERATED * (most / LOOKS as f64).sqrt();
            let (tolerance, largest) = match &mut entry.kind {
                Kind::Count(share) => (share, LARGEST_SHARE),
                Kind::Number(own) => {
                    let largest = LARGEST_MULTIPLE * *own;
                    (own, largest)
                }
            };
            *tolerance = if apart > largest { f64::INFINITY } else { tolerance.max(apart) };
        }
    }
}

/// A verdict as one of poses: thresholds are no findings, and what was not looked for is said.
pub fn of_poses(verdict: &mut Verdict) {
    let is_threshold = |name: &str| name == "threshold_on" || name == "threshold_off";
    let before = verdict.effects.len();
    verdict
        .effects
        .retain(|finding| finding.kind == FindingKind::Effect || !is_threshold(&finding.name));
    if verdict.effects.len() < before {
        verdict.notes.insert(
            1,
            "other thresholds explain part of it, and so would another contrast".to_owned(),
        );
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
        let sentence = &verdict.place.sentence;
        verdict.place.sentence = format!("with what light and texture do: {sentence}");
    }
    let like = LIKE_TEXTURE.map(|(name, why)| (name.to_owned(), why.to_owned()));
    verdict.untestable.extend(like);
    let why = "contrast of the texture and thresholds are one thing";
    verdict.untestable.insert("threshold_on, threshold_off".to_owned(), why.to_owned());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Entry;

    /// A number that looks move far is not compared; one that they move a little is tolerated.
    #[test]
    fn what_looks_differ_by_does_not_count() {
        let mut layout = Layout::of_all_probes();
        let kinds = [Kind::Number(0.1), Kind::Number(0.1), Kind::Count(0.0)];
        let number = |kind| Entry { block: Block::Timing, name: String::new(), kind };
        let first = layout.entries.len();
        layout.entries.extend(kinds.map(number));
        let own = vec![20.0; layout.entries.len()];
        let mut look = own.clone();
        (look[first], look[first + 1]) = (20.2, 30.0);
        let mut spread = Spread::of(&layout);
        (0..LOOKS).for_each(|_| spread.add(1, &layout, &own, &look));
        spread.widen(&mut layout);
        let tolerance = |i: usize| match layout.entries[first + i].kind {
            Kind::Number(tolerance) | Kind::Count(tolerance) => tolerance,
        };
        assert!((tolerance(0) - 0.6).abs() < 1e-9, "{}", tolerance(0));
        assert!(tolerance(1).is_infinite() && tolerance(2) == 0.0);
    }
}
