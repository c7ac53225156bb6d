//! Division of a step into parts, between whose ends `ln(I + I_dark)` is linear in time.

use super::AdaptiveSteps;
use crate::chain::Chain;
use crate::exponential::exp_m1;
use crate::natural_log::ln;
use crate::tick::Tick;
use evpose_cpu::vectorize;

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

    pub(crate) fn retune(&mut self, chain: &Chain) {
        self.steps = chain.steps;
    }

    pub(crate) fn parts(&self, chain: &Chain, tick: &Tick, luminance: &[f32]) -> u32 {
        let Some(steps) = self.steps else { return 1 };
        // The first exposure has no light before it that could be divided.
        if self.before.len() != luminance.len() {
            return 1;
        }
        let dark = dark_light(chain);
        // In ln(I + I_dark), about as the photoreceptor responds: thresholds are steps of that.
        let largest = vectorize(
            #[inline(always)]
            || {
                self.before.iter().zip(luminance).fold(0.0f32, |largest, (before, now)| {
                    let change =
                        (ln(at_least_none(*now) + dark) - ln(at_least_none(*before) + dark)).abs();
                    if change > largest { change } else { largest }
                })
            },
        );
        // Half of a threshold a part, so that no pixel has two events in one, up to `max_parts`.
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
        // The last part is the light itself: a computed one would be rounded.
        if part == parts {
            light.extend_from_slice(now);
            return light;
        }
        let (dark, share) = (dark_light(chain), part as f32 / parts as f32);
        light.resize(now.len(), 0.0);
        vectorize(
            #[inline(always)]
            || {
                for ((light, before), now) in light.iter_mut().zip(&self.before).zip(now) {
                    let from = at_least_none(*before) + dark;
                    // A factor on the light before: small changes keep their precision.
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

/// Maps negative values and NaN to darkness.
#[inline(always)]
fn at_least_none(luminance: f32) -> f32 {
    if luminance > 0.0 && luminance < f32::MAX { luminance } else { 0.0 }
}
