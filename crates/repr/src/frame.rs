//! Representations of a window of whole frames.

use std::fmt::Debug;

use evpose_core::{Polarity, SensorSize};

use crate::ChannelOrder;

/// An event of a window of frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameEvent {
    /// Frame within the window, 0 the oldest.
    pub frame: u32,
    /// Column, 0 at the left.
    pub x: u16,
    /// Row, 0 at the top.
    pub y: u16,
    /// Direction of the change.
    pub polarity: Polarity,
}

/// One event of a window, addressed for writing.
#[derive(Debug, Clone, Copy)]
pub struct Write {
    /// Where this event's pixel lies in its own channel's half of the planes.
    pub pixel: usize,
    /// The same pixel in the other polarity's channel.
    pub other: usize,
    /// When, as a share of the window: 0 is its start, 1 its end.
    pub age: f32,
    /// Whether the same pixel and polarity had an event in this frame already.
    pub repeated: bool,
}

/// How the events of a window become two planes. Events come in time order.
pub trait FrameSurface: Debug + Sync {
    /// Adds one event.
    fn write(&self, planes: &mut [f32], event: Write);

    /// Whether [`Write::repeated`] has to be known, which costs a plane of memory.
    fn needs_repeats(&self) -> bool {
        false
    }
}

/// Everything a window of events needs to become the input of a network.
#[derive(Debug, Clone, Copy)]
pub struct WindowSpec {
    /// How events become pixels.
    pub surface: &'static dyn FrameSurface,
    /// Size of the planes.
    pub sensor: SensorSize,
    /// Which polarity is channel 0.
    pub order: ChannelOrder,
}

impl WindowSpec {
    /// Writes the events of a window of `frames` frames into `planes`, `[2, height, width]`.
    ///
    /// Events must come in time order; `planes` is cleared first. The events of frame `i` have the
    /// age `i / frames`: the oldest frame is 0, the newest one frame short of 1, as published.
    ///
    /// # Panics
    /// If `planes` has another size, or an event lies outside the sensor.
    pub fn fill(
        &self,
        frames: u32,
        events: impl IntoIterator<Item = FrameEvent>,
        planes: &mut [f32],
    ) {
        let pixels = self.sensor.pixels();
        assert_eq!(planes.len(), 2 * pixels, "two planes of {}", self.sensor);
        planes.fill(0.0);
        let width = usize::from(self.sensor.width);
        // The last frame in which each pixel and polarity had an event, plus one.
        let mut last = vec![0u32; if self.surface.needs_repeats() { 2 * pixels } else { 0 }];
        let scale = 1.0 / frames as f32;
        for FrameEvent { frame, x, y, polarity } in events {
            let channel = self.order.channel(polarity);
            let at = usize::from(y) * width + usize::from(x);
            let pixel = channel * pixels + at;
            let repeated = match last.get_mut(pixel) {
                Some(last) => std::mem::replace(last, frame + 1) == frame + 1,
                None => false,
            };
            let other = (1 - channel) * pixels + at;
            self.surface.write(planes, Write { pixel, other, age: frame as f32 * scale, repeated });
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    const SENSOR: SensorSize = SensorSize { width: 3, height: 2 };

    pub(crate) fn event(frame: u32, x: u16, y: u16, polarity: Polarity) -> FrameEvent {
        FrameEvent { frame, x, y, polarity }
    }

    /// The planes of a window of four frames on a 3x2 sensor, OFF first.
    pub(crate) fn planes(name: &str, events: &[FrameEvent]) -> Vec<f32> {
        let surface = crate::by_name(name).map(|spec| spec.surface);
        let mut planes = vec![9.0; 12];
        let spec = WindowSpec {
            surface: surface.unwrap_or(&crate::lnes::Lnes),
            sensor: SENSOR,
            order: ChannelOrder::OffFirst,
        };
        spec.fill(4, events.iter().copied(), &mut planes);
        planes
    }

    #[test]
    fn channels_rows_and_columns_are_where_they_should_be() {
        let planes = planes("eoi", &[event(1, 2, 0, Polarity::Off), event(2, 0, 1, Polarity::On)]);
        let mut expected = [0.0; 12];
        expected[2] = 1.0; // channel 0 (OFF), row 0, column 2
        expected[6 + 3] = 1.0; // channel 1 (ON), row 1, column 0
        assert_eq!(planes, expected);
    }

    #[test]
    fn a_window_without_events_is_empty() {
        for spec in crate::REPRESENTATIONS {
            assert!(planes(spec.name, &[]).iter().all(|&v| v == 0.0), "{}", spec.name);
        }
    }

    #[test]
    fn swapping_polarities_swaps_the_channels_of_every_representation() {
        let events = [
            event(0, 1, 1, Polarity::On),
            event(1, 1, 1, Polarity::On),
            event(3, 0, 0, Polarity::Off),
        ];
        let flipped = events.map(|e| FrameEvent { polarity: e.polarity.flipped(), ..e });
        for spec in crate::REPRESENTATIONS {
            let (a, b) = (planes(spec.name, &events), planes(spec.name, &flipped));
            assert_eq!([&a[6..], &a[..6]].concat(), b, "{}", spec.name);
        }
    }
}
