//! Events against events: what two models that differ by less than tolerances are told apart by.
//!
//! Probes allow for scenes that are known to some share of a frame only. Where two candidates are
//! both within that, a delay and a slow stage for example, events themselves may still say which
//! it is: how far each is from the nearest of its kind, in the same pixel and of the same polarity.

use evpose_core::EventStream;
use evpose_sensor::SensorConfig;

use crate::{Expected, GapError, Lab};

/// Events further from the nearest are as good as alone, microseconds.
const ALONE_US: f64 = 1_000.0;

/// Mean distance of measured events to the nearest that the model has, and of those to the nearest
/// measured one, as a share of the distance from which an event is alone: 0 where all are the same.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(crate) fn distance(lab: &Lab<'_>, model: &SensorConfig) -> Result<f64, GapError> {
    let simulated = lab.stage.simulate(model, 1)?;
    let far = |from: &EventStream, to: &EventStream| {
        let to = Expected::of(to);
        let width = usize::from(from.sensor().width);
        let window = from.slice(lab.window);
        let sum: f64 = window
            .iter()
            .map(|event| {
                let pixel = usize::from(event.y) * width + usize::from(event.x);
                let times = to.times(pixel, event.polarity.is_on());
                let next = times.partition_point(|t_us| *t_us < event.t.0);
                let beside = [next.checked_sub(1).and_then(|i| times.get(i)), times.get(next)];
                let least = beside.into_iter().flatten().map(|t_us| (t_us - event.t.0).abs()).min();
                least.map_or(1.0, |us| (us as f64 / ALONE_US).min(1.0))
            })
            .sum();
        sum / window.len().max(1) as f64
    };
    Ok(0.5 * (far(&lab.events, &simulated) + far(&simulated, &lab.events)))
}
