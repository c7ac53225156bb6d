//! Light in steps, read off: where light changes slowly, events come where it reaches the next step.
//!
//! # Method
//! Light of `n` equal steps changes at `(k + 1/2) / n` of white. Over the events of pixels whose light
//! changes by less than part of a step between two frames, the mean of `-cos(2 pi n I)` is then near
//! one, and near zero where light is even. Odd multiples of the right `n` do as well, so that the
//! smallest is taken. A scene that has few values of light anyway is at some `n` by itself: the events
//! that it lets expect are asked too.

use evpose_core::EventStream;
use std::f64::consts::TAU;

use super::recording_marks::Reading;
use crate::{Expected, LightSequence};

/// Steps between black and white that are looked for, and their interval.
const STEPS: (f64, f64) = (8.0, 130.0);
const INTERVAL: f64 = 0.05;
/// Change of light between two frames, in steps, below which it is slow.
const SLOW: f64 = 0.4;
/// Events at least, and at most: more add nothing.
const MIN_EVENTS: usize = 200;
const MAX_EVENTS: usize = 20_000;
/// Mean from which steps are there, above that of the expected events.
const MIN_MEAN: f64 = 0.5;
/// Part of the largest mean at which a smaller number of steps is as good.
const AS_GOOD: f64 = 0.9;
/// Distance from a whole number of steps that counts as none.
const WHOLE: f64 = 0.2;

/// Number of steps of light between black and white; none where light is even.
pub(super) fn light_steps(
    events: &EventStream,
    expected: &Expected,
    scene: &LightSequence,
) -> Option<Reading> {
    let width = usize::from(events.sensor().width);
    let at = |event: evpose_core::Event| {
        (usize::from(event.y) * width + usize::from(event.x), event.t.0)
    };
    let measured = Lights::of(scene, events.iter().map(at));
    let counts: Vec<f64> =
        (0..).map(|i| STEPS.0 + INTERVAL * f64::from(i)).take_while(|n| *n < STEPS.1).collect();
    let means: Vec<f64> = counts.iter().map(|n| measured.mean(*n).unwrap_or(0.0)).collect();
    let best = means.iter().copied().fold(0.0, f64::max);
    if best < MIN_MEAN {
        return None;
    }
    // The first that is nearly the best, since multiples of it fit as well.
    let first = means.iter().position(|mean| *mean >= AS_GOOD * best)?;
    // The first is on the flank of its peak.
    let peak =
        (first..means.len()).take_while(|i| *i == first || means[*i] >= means[i - 1]).last()?;
    let pixels = 0..events.sensor().pixels();
    let of_pixel = |pixel: usize| {
        let times = [false, true].map(|is_on| expected.times(pixel, is_on).iter());
        times.into_iter().flatten().map(move |t_us| (pixel, *t_us))
    };
    // A scene may have steps of its own, which the reference then shows, too.
    let by_itself = Lights::of(scene, pixels.flat_map(of_pixel)).mean(counts[peak]).unwrap_or(0.0);
    if means[peak] - by_itself < MIN_MEAN {
        return None;
    }
    let whole = counts[peak].round();
    let levels = if (counts[peak] - whole).abs() < WHOLE { whole } else { counts[peak] };
    Some(Reading::new([("levels", levels.into())], 0.0))
}

/// Light at events, and its change between two frames, the slowest first.
struct Lights(Vec<(f64, f64)>);

impl Lights {
    fn of(scene: &LightSequence, events: impl Iterator<Item = (usize, i64)>) -> Self {
        let planes = scene.planes();
        let mut lights: Vec<(f64, f64)> = events
            .filter_map(|(pixel, t_us)| {
                // A stamp on a frame is of the change up to it.
                let behind = (1e-6 * (t_us - 1) as f64 * scene.fps()).floor();
                let k = if behind >= 0.0 { behind as usize } else { return None };
                let [before, after] = [planes.get(k)?, planes.get(k + 1)?]
                    .map(|plane| f64::from(plane.data()[pixel]));
                let change = (after - before).abs();
                (change > 0.0).then_some((0.5 * (before + after), change))
            })
            .collect();
        lights.sort_by(|a, b| a.1.total_cmp(&b.1));
        Self(lights)
    }

    /// Mean of `-cos(2 pi n I)` over the events at which light changes slowly; none if these are few.
    fn mean(&self, n: f64) -> Option<f64> {
        let slow = self.0.partition_point(|(_, change)| change * n < SLOW);
        if slow < MIN_EVENTS {
            return None;
        }
        let stride = slow.div_ceil(MAX_EVENTS);
        let used = self.0[..slow].iter().step_by(stride);
        let (sum, count) = used.fold((0.0, 0.0), |(sum, count), (light, _)| {
            (sum - (TAU * n * light).cos(), count + 1.0)
        });
        Some(sum / count)
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Plane;
    use evpose_sensor::{EffectConfig, SensorConfig};

    use super::*;

    /// Steps read off a slow ramp seen by a sensor with `levels` of light.
    fn steps(levels: f64) -> Option<f64> {
        let planes = (0..200_u16).map(|k| {
            let at = |i: u16| {
                0.05 + 0.02 * f32::from(i % 32) + 0.002 * f32::from(i / 32) + 0.0011 * f32::from(k)
            };
            Plane::from_vec(32, 32, (0..1024).map(at).collect()).unwrap()
        });
        let scene = LightSequence::new(1_000.0, planes.collect()).unwrap();
        let events = |levels: f64| {
            let config = SensorConfig {
                effects: vec![
                    EffectConfig::new("quantisation").with("levels", levels),
                    EffectConfig::new("level_crossing")
                        .with("threshold_on", 0.03)
                        .with("threshold_off", 0.03),
                ],
            };
            scene.events(&config, 1).unwrap()
        };
        let expected = Expected::from_events(&events(f64::INFINITY));
        light_steps(&events(levels), &expected, &scene)?.number("levels")
    }

    #[test]
    fn steps_are_counted_and_even_light_has_none() {
        assert_eq!(steps(23.0), Some(23.0));
        assert_eq!(steps(60.0), Some(60.0));
        assert_eq!(steps(f64::INFINITY), None);
    }
}
