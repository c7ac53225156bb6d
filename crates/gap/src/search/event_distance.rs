//! Distance between two event streams, event by event.
//!
//! Summary statistics have tolerances of some fraction of a frame, because scenes are known no
//! better. Where two candidates are both within them, a delay and a slow stage for example, the
//! events themselves may still distinguish the two: the statistic is the time from each event to
//! the nearest one of the same pixel and polarity.

use evpose_core::{EventStream, TimeWindow};
use evpose_sensor::SensorConfig;

use crate::{Expected, GapError, Objective};

/// Times to the nearest event, microseconds, are clipped here: such an event has no partner.
const MAX_DISTANCE_US: f64 = 1_000.0;

/// Mean clipped time from measured events to the nearest simulated one and back, as a fraction of
/// the clipping time: 0 for identical streams, 1 for streams without common events.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(super) fn event_distance(
    objective: &Objective<'_>,
    model: &SensorConfig,
) -> Result<f64, GapError> {
    let simulated = objective.reference_scene.simulate(model, 1)?;
    let there = one_way(&objective.events, &simulated, objective.window);
    Ok(0.5 * (there + one_way(&simulated, &objective.events, objective.window)))
}

/// The distance from the events of a window to those of another stream.
fn one_way(from: &EventStream, to: &EventStream, window: TimeWindow) -> f64 {
    let to = Expected::from_events(to);
    let width = usize::from(from.sensor().width);
    let from = from.slice(window);
    let distances = from.iter().map(|event| {
        let pixel = usize::from(event.y) * width + usize::from(event.x);
        let times = to.times(pixel, event.polarity.is_on());
        let next = times.partition_point(|t_us| *t_us < event.t.0);
        let neighbours = [next.checked_sub(1).and_then(|i| times.get(i)), times.get(next)];
        let min_us = neighbours.into_iter().flatten().map(|t_us| (t_us - event.t.0).abs()).min();
        min_us.map_or(1.0, |us| (us as f64 / MAX_DISTANCE_US).min(1.0))
    });
    distances.sum::<f64>() / from.len().max(1) as f64
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
    fn the_distance_is_that_to_the_nearest_event_of_the_same_pixel_and_polarity() {
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
