//! Recordings made up for tests and timing, the same on every machine.

use evpose_core::{
    CounterRng, Event, EventStream, EventStreamBuilder, Micros, Polarity, SensorSize,
};

/// The sensor of the recordings, that of an IMX636.
pub const SENSOR: SensorSize = SensorSize { width: 1280, height: 720 };

/// Single events all over the sensor, on average one a microsecond: hardly two of a row or a time.
pub fn scattered(events: usize) -> EventStream {
    let mut draw = CounterRng::new(1, "scattered events", 0);
    let mut t = 0;
    collect((0..events).map(|_| {
        t += draw.below(3) as i64;
        Event {
            t: Micros(t),
            x: draw.below(SENSOR.width.into()) as u16,
            y: draw.below(SENSOR.height.into()) as u16,
            polarity: Polarity::from_on(draw.chance(0.5)),
        }
    }))
}

/// Edges that sweep over the sensor: in a row every few microseconds, a stretch of 40 to 200 pixels
/// of which two of three have an event.
pub fn edges(events: usize) -> EventStream {
    let mut draw = CounterRng::new(1, "edges", 0);
    let (mut t, mut row, mut on) = (0, 0, false);
    let mut stretch = 0..0_u16;
    let all = std::iter::from_fn(move || {
        loop {
            let Some(x) = stretch.next() else {
                t += 1 + draw.below(8) as i64;
                row = draw.below(SENSOR.height.into()) as u16;
                on = draw.chance(0.5);
                let length = 40 + draw.below(161) as u16;
                let first = draw.below(usize::from(SENSOR.width - length)) as u16;
                stretch = first..first + length;
                continue;
            };
            // Gaps decide whether vectors are worth their words.
            if draw.chance(2.0 / 3.0) {
                return Some(Event { t: Micros(t), x, y: row, polarity: Polarity::from_on(on) });
            }
        }
    });
    collect(all.take(events))
}

fn collect(events: impl Iterator<Item = Event>) -> EventStream {
    let mut builder = EventStreamBuilder::new(SENSOR);
    events.for_each(|event| builder.push(event));
    builder.finish().0
}
