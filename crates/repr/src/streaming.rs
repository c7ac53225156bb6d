//! Representations that follow a stream of events in continuous time.

use std::collections::VecDeque;

use evpose_core::{Event, EventStream, Micros, SensorSize, TimeWindow};

use crate::ChannelOrder;
use crate::frame::{FrameSurface, Write};

/// Events in, dense planes out, incrementally. One instance follows one stream.
pub trait Representation {
    /// Number of planes.
    fn channels(&self) -> usize;

    /// Takes events; they must not be earlier than those before.
    fn push(&mut self, events: &EventStream);

    /// Says what time it is: planes show the window that ends now.
    fn advance(&mut self, now: Micros);

    /// Writes the planes, `[channels, height, width]`.
    ///
    /// # Panics
    /// If `out` has another size.
    fn render(&self, out: &mut [f32]);

    /// Forgets everything.
    fn reset(&mut self);
}

/// Any [`FrameSurface`] over a sliding window of continuous time.
///
/// The window is `[now − length, now)`; an event's age is `(t − start) / length`. On events that lie
/// on whole milliseconds it equals the framed form of the same window.
#[derive(Debug)]
pub struct Sliding {
    surface: &'static dyn FrameSurface,
    sensor: SensorSize,
    order: ChannelOrder,
    length: Micros,
    now: Micros,
    events: VecDeque<Event>,
}

impl Sliding {
    /// Follows a stream from `sensor` with a window of `length`.
    pub fn new(
        surface: &'static dyn FrameSurface,
        sensor: SensorSize,
        order: ChannelOrder,
        length: Micros,
    ) -> Self {
        Self { surface, sensor, order, length, now: Micros(i64::MIN), events: VecDeque::new() }
    }

    fn window(&self) -> TimeWindow {
        TimeWindow { start: Micros(self.now.0.saturating_sub(self.length.0)), end: self.now }
    }
}

impl Representation for Sliding {
    fn channels(&self) -> usize {
        2
    }

    fn push(&mut self, events: &EventStream) {
        self.events.extend(events.iter());
    }

    fn advance(&mut self, now: Micros) {
        self.now = now;
        let start = self.window().start;
        while self.events.front().is_some_and(|event| event.t < start) {
            self.events.pop_front();
        }
    }

    fn render(&self, out: &mut [f32]) {
        let pixels = self.sensor.pixels();
        assert_eq!(out.len(), 2 * pixels, "two planes of {}", self.sensor);
        out.fill(0.0);
        let window = self.window();
        let width = usize::from(self.sensor.width);
        // Milliseconds stand for frames where a representation counts once per frame.
        let mut last = vec![i64::MIN; if self.surface.needs_repeats() { 2 * pixels } else { 0 }];
        for event in self.events.iter().take_while(|event| event.t < window.end) {
            let channel = self.order.channel(event.polarity);
            let at = usize::from(event.y) * width + usize::from(event.x);
            let pixel = channel * pixels + at;
            let millisecond = event.t.0.div_euclid(1000);
            let repeated = match last.get_mut(pixel) {
                Some(last) => std::mem::replace(last, millisecond) == millisecond,
                None => false,
            };
            let age = (event.t - window.start).0 as f32 / self.length.0 as f32;
            let other = (1 - channel) * pixels + at;
            self.surface.write(out, Write { pixel, other, age, repeated });
        }
    }

    fn reset(&mut self) {
        self.events.clear();
        self.now = Micros(i64::MIN);
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Polarity;
    use proptest::prelude::*;

    use super::*;
    use crate::frame::{FrameEvent, WindowSpec};

    const SENSOR: SensorSize = SensorSize { width: 5, height: 4 };

    fn stream(raw: &[(i64, u16, u16, bool)]) -> EventStream {
        let mut stream = EventStream::empty(SENSOR);
        for &(t, x, y, on) in raw {
            let polarity = Polarity::from_on(on);
            assert!(stream.push(Event { t: Micros(t), x, y, polarity }).is_ok());
        }
        stream
    }

    fn sliding(spec: &crate::Spec) -> Sliding {
        Sliding::new(spec.surface, SENSOR, ChannelOrder::OffFirst, Micros(100_000))
    }

    fn rendered(sliding: &Sliding) -> Vec<f32> {
        let mut out = vec![0.0; 2 * SENSOR.pixels()];
        sliding.render(&mut out);
        out
    }

    prop_compose! {
        fn raw_events()(mut raw in prop::collection::vec(
            (0i64..200, 0u16..5, 0u16..4, any::<bool>()), 0..200)) -> Vec<(i64, u16, u16, bool)> {
            raw.sort_by_key(|event| event.0);
            raw
        }
    }

    proptest! {
        #[test]
        fn how_a_stream_is_cut_up_does_not_matter(raw in raw_events(), cut in 0usize..200) {
            let cut = cut.min(raw.len());
            for spec in crate::REPRESENTATIONS {
                let (mut whole, mut parts) = (sliding(spec), sliding(spec));
                whole.push(&stream(&raw));
                parts.push(&stream(&raw[..cut]));
                parts.push(&stream(&raw[cut..]));
                whole.advance(Micros(150));
                parts.advance(Micros(150));
                prop_assert_eq!(rendered(&whole), rendered(&parts));
            }
        }

        #[test]
        fn on_whole_milliseconds_it_equals_the_framed_form(raw in raw_events()) {
            let raw: Vec<_> = raw.into_iter().map(|(t, x, y, on)| (t * 1000, x, y, on)).collect();
            let (start, end) = (50, 150);
            for spec in crate::REPRESENTATIONS {
                let mut sliding = sliding(spec);
                sliding.push(&stream(&raw));
                sliding.advance(Micros(end * 1000));
                let window = WindowSpec {
                    surface: spec.surface, sensor: SENSOR, order: ChannelOrder::OffFirst,
                };
                let inside = raw.iter().filter(|e| (start..end).contains(&(e.0 / 1000)));
                let events = inside.map(|&(t, x, y, on)| FrameEvent {
                    frame: (t / 1000 - start) as u32, x, y, polarity: Polarity::from_on(on),
                });
                let mut framed = vec![0.0; 2 * SENSOR.pixels()];
                window.fill(100, events, &mut framed);
                for (a, b) in rendered(&sliding).iter().zip(&framed) {
                    prop_assert!((a - b).abs() < 1e-6, "{}: {a} {b}", spec.name);
                }
            }
        }
    }

    #[test]
    fn nothing_is_left_after_a_reset() {
        let mut sliding = sliding(&crate::REPRESENTATIONS[1]);
        sliding.push(&stream(&[(10, 1, 1, true)]));
        sliding.advance(Micros(20));
        assert!(rendered(&sliding).contains(&1.0));
        sliding.reset();
        sliding.advance(Micros(20));
        assert!(rendered(&sliding).iter().all(|&v| v == 0.0));
    }
}
