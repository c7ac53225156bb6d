//! The short way through a step: a pixel on which nothing acts but the levels that it crosses.
//!
//! # Model
//! That of [`level_crossing`](super::level_crossing), operation by operation, so that a pixel has
//! the same events to the last bit whichever way it goes.

use evpose_core::Polarity;

use super::PixelArray;
use super::resolve::Step;
use crate::{Origin, Request};

impl PixelArray {
    /// Takes a pixel through the step, unless it is beyond a level from the start: false then, and
    /// nothing is done.
    #[inline(always)]
    pub(super) fn resolve_straight(
        &mut self,
        step: Step<'_>,
        pixel: u32,
        out: &mut Vec<Request>,
    ) -> bool {
        let index = pixel as usize;
        let (start_s, end_s) = (step.tick.start_s, step.tick.end_s);
        let leak = self.leak_per_s.get(index).map_or(0.0, |&leak| f64::from(leak));
        let from = f64::from(step.before[index]) + leak * (start_s - self.anchor_s);
        let to = f64::from(step.after[index]) + leak * (end_s - self.anchor_s);
        let cell = &mut self.cells[index];
        let mut memory = f64::from(cell.memory);
        let (on, off) = (f64::from(cell.threshold_on), f64::from(cell.threshold_off));
        if from >= memory + on || from <= memory - off {
            return false;
        }
        let polarity = if to > memory { Polarity::On } else { Polarity::Off };
        let (threshold, sign) = if polarity.is_on() { (on, 1.0) } else { (-off, -1.0) };
        let mut level = memory + threshold;
        // Most pixels that wake have an event; some woke a rounding too early.
        if (to - level) * sign >= 0.0 {
            let drained =
                leak * (end_s - start_s) + self.seeped.get(index).map_or(0.0, |&s| f64::from(s));
            let is_leak = drained > 0.0 && 2.0 * drained > to - from && polarity.is_on();
            let origin = if is_leak { Origin::Leak } else { Origin::Signal };
            let mut now_s = start_s;
            while (to - level) * sign >= 0.0 {
                let way = (level - from) / (to - from);
                now_s = (start_s + (end_s - start_s) * way).max(now_s).min(end_s);
                out.push(Request { t_s: now_s, pixel, polarity, origin });
                cell.count = cell.count.wrapping_add(1);
                memory = level;
                level = memory + threshold;
            }
            cell.memory = memory as f32;
            self.arm(index, end_s, false);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use evpose_core::{Event, Micros, Plane, SensorSize};
    use proptest::prelude::*;

    use crate::{EffectConfig, SensorConfig, SensorModel};

    const SIZE: SensorSize = SensorSize { width: 40, height: 5 };

    fn events(effects: &[EffectConfig], speed: f32) -> Vec<Event> {
        let config = SensorConfig { effects: effects.to_vec() };
        let mut run = SensorModel::from_config(&config).unwrap().start(SIZE, 3);
        let mut all = Vec::new();
        for step in 0..30 {
            let mut plane = Plane::for_sensor(SIZE, 0.0);
            for (i, y) in plane.data_mut().iter_mut().enumerate() {
                *y = 0.02 + 0.4 * (1.0 + (i as f32 * 0.21 + speed * step as f32).sin());
            }
            all.extend(run.expose(&plane, Micros(step * 1_000)).unwrap().iter());
        }
        all
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// A dead time shorter than any interval changes nothing but the way that pixels go.
        #[test]
        fn both_ways_give_the_same_events(speed in -1.0..1.0f32, leak in any::<bool>()) {
            let mut effects = vec![EffectConfig::new("threshold_mismatch").with("sigma", 0.02)];
            if leak {
                effects.push(EffectConfig::new("leak_on").with("rate_hz", 20.0));
            }
            let short = events(&effects, speed);
            let deaf = EffectConfig::new("refractory").with("period_us", 1.0);
            effects.push(deaf.with("mode", "defer"));
            prop_assert!(short.len() > 10 || speed.abs() < 0.1);
            prop_assert_eq!(short, events(&effects, speed));
        }
    }
}
