//! The short way through a step: a pixel on which nothing acts but the levels that it crosses.
//!
//! # Model
//! That of [`level_crossing`](super::level_crossing), operation by operation, so that a pixel has
//! the same events to the last bit whichever way it goes.

use evpose_core::Polarity;

use super::band::Band;
use super::pixel::{Cell, RefractoryState};
use super::resolve::Step;
use crate::{Origin, Request};

impl Band<'_> {
    /// Takes a pixel through the step, unless it is beyond a level from the start: false then, and
    /// nothing is done.
    pub(super) fn resolve_crossings(
        &mut self,
        step: Step<'_>,
        pixel: u32,
        out: &mut Vec<Request>,
    ) -> bool {
        let index = pixel as usize;
        let (start_s, end_s) = (step.tick.start_s, step.tick.end_s);
        // As in the batches, to the last bit: which of both a pixel takes must not matter.
        let leak = self.leak_per_s.get(index).map_or(0.0, |&leak| f64::from(leak));
        let from = f64::from(step.before.at(index)) + leak * (start_s - self.anchor_s);
        let to = f64::from(step.after.at(index)) + leak * (end_s - self.anchor_s);
        let change = to - from;
        let at = |t_s: f64| match () {
            () if t_s >= end_s => to,
            () if t_s <= start_s => from,
            () => from + change * ((t_s - start_s) * step.per_s),
        };
        let Cell { memory, threshold_on, threshold_off, .. } = self.cells[index];
        let mut memory = f64::from(memory);
        let mut refractory =
            self.refractory_states.get(index).copied().unwrap_or(RefractoryState::NONE);
        let mut now_s = later(start_s, refractory.follows_until_s);
        if refractory.follows_until_s > f64::NEG_INFINITY && now_s <= end_s {
            memory = at(refractory.follows_until_s);
            refractory.follows_until_s = f64::NEG_INFINITY;
        }
        now_s = later(now_s, refractory.free_s);
        let now = at(now_s);
        let (on, off) = (f64::from(threshold_on), f64::from(threshold_off));
        // A pixel beyond a level has an event at once, which is no crossing.
        if now_s <= end_s && (now >= memory + on || now <= memory - off) {
            return false;
        }
        // On a line all events of a step have one sign.
        let is_rise = change > 0.0;
        let polarity = Polarity::from_on(is_rise);
        let (threshold, sign) = if is_rise { (on, 1.0) } else { (-off, -1.0) };
        let drained =
            leak * (end_s - start_s) + self.leaked_in_step.get(index).map_or(0.0, |&s| s.into());
        let is_leak = drained > 0.0 && 2.0 * drained > change && is_rise;
        let origin = if is_leak { Origin::Leak } else { Origin::Signal };
        let recovery = &step.chain.plan.recovery;
        let mut count = 0u32;
        while now_s <= end_s {
            let level = memory + threshold;
            if (to - level) * sign < 0.0 {
                break;
            }
            let way = (level - from) / change;
            let t_s = sooner(later(start_s + (end_s - start_s) * way, now_s), end_s);
            out.push(Request { t_s, pixel, polarity, origin });
            count += 1;
            memory = level - recovery.short_fraction * threshold;
            refractory = RefractoryState::after(t_s, end_s, recovery);
            now_s = later(t_s, refractory.follows_until_s);
            // The reference level followed the voltage until then: the memory is what it was there.
            if refractory.follows_until_s > f64::NEG_INFINITY && now_s <= end_s {
                memory = at(refractory.follows_until_s);
                refractory.follows_until_s = f64::NEG_INFINITY;
            }
            now_s = later(now_s, refractory.free_s);
        }
        let cell = &mut self.cells[index];
        cell.memory = memory as f32;
        cell.count = cell.count.wrapping_add(count);
        if let Some(kept) = self.refractory_states.get_mut(index) {
            *kept = refractory;
        }
        self.set_wake_levels(index, end_s, false);
        true
    }
}

/// The later of two times. One instruction, as no time is NaN; [`f64::max`] takes five.
#[inline(always)]
pub(super) fn later(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
pub(super) fn sooner(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use crate::testing::events_of_waves;
    use crate::{EffectConfig, SensorConfig};

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn both_ways_give_the_same_events(
            speed in -1.0..1.0f32, leak in any::<bool>(), period_us in 0..4_000u32,
            mode in prop::sample::select(vec!["hold", "defer"]), fraction in -0.3..0.3f64,
            photo_leak in any::<bool>(), shot in any::<bool>(),
        ) {
            let mut effects = vec![EffectConfig::new("threshold_mismatch").with("sigma", 0.02)];
            if leak {
                effects.push(EffectConfig::new("leak_on").with("rate_hz", 20.0));
            }
            if photo_leak {
                effects.push(EffectConfig::new("parasitic_photo_leak").with("hz_per_white", 20.0));
            }
            if shot {
                effects.push(EffectConfig::new("shot_noise_poisson").with("rate_hz", 50.0));
            }
            if period_us > 1_000 {
                let refractory = EffectConfig::new("refractory").with("mode", mode);
                effects.push(refractory.with("period_us", f64::from(period_us - 1_000)));
            } else if period_us > 500 {
                effects.push(EffectConfig::new("reset_overshoot").with("fraction", fraction));
            }
            let config = SensorConfig { effects };
            let events = |is_short| events_of_waves(&config, speed, is_short, |_, _| {});
            let short = events(true);
            prop_assert!(short.len() > 10 || speed.abs() < 0.1);
            prop_assert_eq!(short, events(false));
        }
    }
}
