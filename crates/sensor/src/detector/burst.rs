//! The short way through a step for detectors that compare frames: a pixel on which nothing acts
//! but its light, and whose events all happen when the frame does.
//!
//! # Model
//! That of the long way, so that a pixel has the same events whichever way it goes.

use super::band::Band;
use super::resolve::Step;
use crate::{Origin, Request};

impl Band<'_> {
    #[inline(always)]
    pub(super) fn resolve_burst(&mut self, step: Step<'_>, pixel: usize, out: &mut Vec<Request>) {
        let pixel_step = self.step_of(step, pixel);
        let detector = &step.chain.detector.stage;
        let change = detector.next(&pixel_step, step.tick.start_s, step.noise);
        let cell = &mut self.cells[pixel];
        if let Some(change) = change.filter(|change| change.count > 0) {
            for _ in 0..change.count {
                out.push(Request {
                    t_s: change.t_s,
                    pixel: pixel_step.pixel,
                    polarity: change.polarity,
                    origin: Origin::Signal,
                });
            }
            cell.memory = change.memory as f32;
            cell.count = cell.count.wrapping_add(change.count);
        }
        // Also without an event: a pixel that woke a little early would wake in every step
        // otherwise.
        match detector.event_limits(cell.memory, [cell.threshold_on, cell.threshold_off]) {
            Some([on, off]) => (self.wake_on[pixel], self.wake_off[pixel]) = (on, off),
            None => self.set_wake_levels(pixel, step.tick.end_s, false),
        }
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Micros, Plane};
    use proptest::prelude::*;

    use crate::plan::PixelPath;
    use crate::testing::{SIZE, events_of_waves};
    use crate::{EffectConfig, SensorConfig, SensorModel};

    fn events(config: &SensorConfig, speed: f32, is_short: bool) -> Vec<Event> {
        let mut other = config.clone();
        other.set("frame_difference", "threshold_on", 0.3).unwrap();
        let other = SensorModel::from_config(&other).unwrap();
        events_of_waves(config, speed, is_short, |step, run| {
            if step == 17 {
                run.retune(&other).unwrap();
            }
        })
    }

    #[test]
    fn pixels_exactly_one_threshold_away_are_not_asked_again() {
        let config = SensorConfig::preset("eventhands").unwrap();
        let mut run = SensorModel::from_config(&config).unwrap().start(SIZE, 3);
        let mut found = |step: i64, light| {
            run.expose(&Plane::for_sensor(SIZE, light), Micros(step * 1_000)).unwrap();
            run.array_mut().whole().awake_count()
        };
        // One threshold of 0.5 above darkness, and dark again.
        assert_eq!(found(0, 0.0), 0);
        assert_eq!(found(1, 1.0 / 255.0), SIZE.pixels());
        assert_eq!([found(2, 0.0), found(3, 0.0)], [0, 0]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn both_ways_give_the_same_events(
            speed in -1.0..1.0f32, on in 0.02..0.5f64, off in 0.02..0.5f64, cold in any::<bool>(),
            noise in any::<bool>(), differ in any::<bool>(),
        ) {
            let start = if cold { "cold" } else { "settled" };
            let detector = EffectConfig::new("frame_difference").with("start", start);
            let mut effects = vec![detector.with("threshold_on", on).with("threshold_off", off)];
            if differ {
                effects.push(EffectConfig::new("threshold_mismatch").with("sigma", 0.02));
                effects.push(EffectConfig::new("dead_pixels").with("fraction", 0.1));
            }
            if noise {
                effects.push(EffectConfig::new("uniform_noise").with("on_hz", 20.0));
            }
            let config = SensorConfig { effects };
            let model = SensorModel::from_config(&config).unwrap();
            prop_assert_eq!(model.chain().plan.path, PixelPath::Bursts);
            let short = events(&config, speed, true);
            prop_assert!(short.len() > 10 || speed.abs() < 0.2);
            prop_assert_eq!(short, events(&config, speed, false));
        }
    }
}
