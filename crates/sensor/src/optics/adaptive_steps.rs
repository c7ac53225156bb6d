//! Steps short enough for what happens in them.
//!
//! A chain without time constants is exact for any step: log voltage runs in a line and its
//! crossings are solved for. Filters answer to the line with a curve, of which the chain knows the
//! ends only. Dividing a step brings the curve back.
//!
//! # Model
//! A step is divided in `n = min(max_parts, ⌈max |ΔV| / (C / 2)⌉, ⌈dt / τ⌉)`, whichever of the two
//! is larger, with `ΔV` the change of log voltage of any pixel, `C` the smaller threshold and `τ`
//! the shortest time constant. In between, `ln(I + I_dark)` runs in a line.
//!
//! # Source
//! The criterion of Rebecq et al. 2018 (ESIM), section 3.1, on brightness change.

use crate::exponential::exp_m1;
use crate::model::Chain;
use crate::natural_log::ln;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::{Stage, Tick};
use crate::wide::wide;
use crate::{Citation, Domain, ParamSpec, Prior, Scale, StageSpec};

const MAX_PARTS: ParamSpec = ParamSpec {
    name: "max_parts",
    unit: "",
    range: (1.0, 1000.0),
    scale: Scale::Log,
    prior: Prior::Fixed,
    neutral: Some(1.0),
    doc: "the most parts a step is divided in",
};

/// The registry entry.
pub(crate) static SPEC: StageSpec = StageSpec {
    name: "adaptive_steps",
    domain: Domain::Optics,
    summary: "steps are divided where light changes a lot or a time constant is short",
    formula: "n = min(max_parts, max(max |dV| / (C / 2), dt / tau))",
    params: &[MAX_PARTS],
    choices: &[],
    files: &[],
    source: Citation {
        key: "Rebecq et al. 2018",
        text: "H. Rebecq, D. Gehrig, D. Scaramuzza: ESIM: an Open Event Camera Simulator, CoRL 2018",
    },
    signature: Signature {
        look_for: "with a filter, whole steps give a step response of straight pieces and late \
                   first events; divided ones come nearer to the exponential",
        probe: Probe::CoarseStepResponse,
        strength: Strength::Rising(&["max_parts"]),
        beside: &["photoreceptor_lowpass"],
    },
    build: |settings| {
        let max_parts = settings.number(&MAX_PARTS).round() as u32;
        Ok(Stage::Steps(AdaptiveSteps { max_parts }))
    },
};

/// How finely steps may be divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AdaptiveSteps {
    max_parts: u32,
}

impl AdaptiveSteps {
    /// Whether steps stay as they are.
    pub fn is_neutral(&self) -> bool {
        self.max_parts <= 1
    }
}

/// Divides the steps of one run.
#[derive(Debug)]
pub(crate) struct Divider {
    steps: Option<AdaptiveSteps>,
    /// Light of the exposure before, and room to work in.
    before: Vec<f32>,
    light: Vec<f32>,
}

impl Divider {
    pub(crate) fn new(chain: &Chain) -> Self {
        Self { steps: chain.steps, before: Vec::new(), light: Vec::new() }
    }

    /// Goes on with the parameters of another chain.
    pub(crate) fn retune(&mut self, chain: &Chain) {
        self.steps = chain.steps;
    }

    /// How many parts a step has.
    pub(crate) fn parts(&self, chain: &Chain, tick: &Tick, luminance: &[f32]) -> u32 {
        let Some(steps) = self.steps else { return 1 };
        if self.before.len() != luminance.len() {
            return 1;
        }
        let dark = dark_light(chain);
        let largest = wide(
            #[inline(always)]
            || {
                self.before.iter().zip(luminance).fold(0.0f32, |largest, (before, now)| {
                    let change =
                        (ln(at_least_none(*now) + dark) - ln(at_least_none(*before) + dark)).abs();
                    if change > largest { change } else { largest }
                })
            },
        );
        let [on, off] = chain.detector.stage.thresholds();
        let for_light = f64::from(largest) / f64::from(0.5 * on.min(off));
        let for_time = chain.time_constant_s().map_or(0.0, |tau_s| tick.dt_s() / tau_s);
        // A cast of what is too large saturates.
        (for_light.max(for_time).ceil() as u32).clamp(1, steps.max_parts)
    }

    /// Light at the end of a part; to be given back.
    pub(crate) fn light(&mut self, chain: &Chain, now: &[f32], part: u32, parts: u32) -> Vec<f32> {
        let mut light = std::mem::take(&mut self.light);
        light.clear();
        if part == parts {
            light.extend_from_slice(now);
            return light;
        }
        let (dark, share) = (dark_light(chain), part as f32 / parts as f32);
        light.resize(now.len(), 0.0);
        wide(
            #[inline(always)]
            || {
                for ((light, before), now) in light.iter_mut().zip(&self.before).zip(now) {
                    let from = at_least_none(*before) + dark;
                    let change = ln(at_least_none(*now) + dark) - ln(from);
                    *light = at_least_none(from * (1.0 + exp_m1(share * change)) - dark);
                }
            },
        );
        light
    }

    pub(crate) fn give_back(&mut self, light: Vec<f32>) {
        self.light = light;
    }

    /// Keeps the light of an exposure for the step behind it.
    pub(crate) fn keep(&mut self, luminance: &[f32]) {
        if self.steps.is_some() {
            self.before.clear();
            self.before.extend_from_slice(luminance);
        }
    }
}

fn dark_light(chain: &Chain) -> f32 {
    chain.photoreceptor().map_or(1e-3, |law| law.dark_light())
}

/// What is no light is darkness.
#[inline(always)]
fn at_least_none(luminance: f32) -> f32 {
    if luminance > 0.0 && luminance < f32::MAX { luminance } else { 0.0 }
}
