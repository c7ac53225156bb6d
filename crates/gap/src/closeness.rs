//! Events against events: what two models that differ by less than tolerances are told apart by.
//!
//! Probes allow for scenes that are known to some share of a frame only. Where two candidates are
//! both within that, a delay and a slow stage for example, events themselves may still say which
//! it is: how far each is from the nearest of its kind, in the same pixel and of the same polarity.

use evpose_core::{EventStream, TimeWindow};
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
    let there = one_way(&lab.events, &simulated, lab.window);
    Ok(0.5 * (there + one_way(&simulated, &lab.events, lab.window)))
}

/// The same for the events of a window alone.
fn one_way(from: &EventStream, to: &EventStream, window: TimeWindow) -> f64 {
    let to = Expected::of(to);
    let width = usize::from(from.sensor().width);
    let from = from.slice(window);
    let far = from.iter().map(|event| {
        let pixel = usize::from(event.y) * width + usize::from(event.x);
        let times = to.times(pixel, event.polarity.is_on());
        let next = times.partition_point(|t_us| *t_us < event.t.0);
        let beside = [next.checked_sub(1).and_then(|i| times.get(i)), times.get(next)];
        let least = beside.into_iter().flatten().map(|t_us| (t_us - event.t.0).abs()).min();
        least.map_or(1.0, |us| (us as f64 / ALONE_US).min(1.0))
    });
    far.sum::<f64>() / from.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Micros, Polarity, SensorSize};

    use super::*;

    fn stream(late_us: i64, y: u16) -> EventStream {
        let event = |k: i64| Event {
            t: Micros(10_000 * k + late_us),
            x: 1,
            y,
            polarity: Polarity::from_on(k % 2 == 0),
        };
        let size = SensorSize { width: 3, height: 2 };
        EventStream::from_events(size, (0..50).map(event)).unwrap()
    }

    #[test]
    fn events_are_as_far_as_the_nearest_of_their_pixel_and_polarity() {
        let window = TimeWindow { start: Micros(0), end: Micros(1_000_000) };
        let distance = |late_us, y| one_way(&stream(0, 0), &stream(late_us, y), window);
        assert!(distance(0, 0) < 1e-12);
        assert!((distance(300, 0) - 0.3).abs() < 1e-12);
        // An event of the other polarity is nearer; one of another pixel is none.
        assert!((distance(9_800, 0) - 1.0).abs() < 1e-12);
        assert!((distance(0, 1) - 1.0).abs() < 1e-12);
        let nothing = EventStream::empty(SensorSize { width: 3, height: 2 });
        assert!(one_way(&nothing, &stream(0, 0), window) < 1e-12);
    }
}
