//! Events to represent.

use evpose_core::{CounterRng, Event, EventStream, Micros, Polarity, SensorSize};

use super::WINDOW;

/// A hundred blobs of 24 pixels that wander, and every tenth event noise.
pub(super) fn wandering(sensor: SensorSize, count: usize) -> EventStream {
    let mut rng = CounterRng::new(7, "events", 0);
    let (width, height) = (f32::from(sensor.width), f32::from(sensor.height));
    let mut blobs: Vec<[f32; 2]> =
        (0..100).map(|_| [rng.uniform(0.0, width), rng.uniform(0.0, height)]).collect();
    // A step of at most half a pixel per event: blobs stay blobs.
    let place = |i: usize| {
        let blob = &mut blobs[rng.below(100)];
        *blob = [blob[0] + rng.uniform(-0.5, 0.5), blob[1] + rng.uniform(-0.5, 0.5)];
        let [x, y] = if i.is_multiple_of(10) {
            [rng.uniform(0.0, width), rng.uniform(0.0, height)]
        } else {
            blob.map(|v| v + rng.uniform(-12.0, 12.0))
        };
        (x, y, rng.chance(0.5))
    };
    stream(sensor, count, place)
}

/// Everywhere at once: what caches help least with.
pub(super) fn uniform(sensor: SensorSize, count: usize) -> EventStream {
    let mut rng = CounterRng::new(8, "events", 0);
    let (width, height) = (f32::from(sensor.width), f32::from(sensor.height));
    stream(sensor, count, |_| (rng.uniform(0.0, width), rng.uniform(0.0, height), rng.chance(0.5)))
}

/// Events at these places, evenly in time.
fn stream(
    sensor: SensorSize,
    count: usize,
    mut place: impl FnMut(usize) -> (f32, f32, bool),
) -> EventStream {
    let events = (0..count).map(|i| {
        let (x, y, is_on) = place(i);
        Event {
            t: Micros(i as i64 * WINDOW.0 / count as i64),
            x: x.clamp(0.0, f32::from(sensor.width - 1)) as u16,
            y: y.clamp(0.0, f32::from(sensor.height - 1)) as u16,
            polarity: Polarity::from_on(is_on),
        }
    });
    // Stamps go up with i, and places are clamped.
    EventStream::from_events(sensor, events).unwrap_or_else(|_| unreachable!("in order and inside"))
}
