//! Events of frames of 1 ms in memory, at four bytes each.

use std::ops::Range;

use evpose_core::{Polarity, SensorSize};
use evpose_repr::FrameEvent;

/// Bit of the polarity in the second word of an event; the row is in the others.
const ON: u16 = 1 << 15;

/// Frames of 1 ms with their events.
///
/// Memory: 4 bytes an event and 8 bytes a frame.
#[derive(Debug)]
pub(crate) struct PackedEvents {
    sensor: SensorSize,
    /// Column, and row with polarity.
    events: Vec<[u16; 2]>,
    /// Count of events up to the end of each frame.
    ends: Vec<u64>,
}

impl PackedEvents {
    /// No frames yet, of a sensor of up to 32768 rows; none if it is taller.
    pub(crate) fn new(sensor: SensorSize) -> Option<Self> {
        (sensor.height <= ON).then(|| Self { sensor, events: Vec::new(), ends: Vec::new() })
    }

    pub(crate) fn sensor(&self) -> SensorSize {
        self.sensor
    }

    /// Appends frames up to `frame`, which is the last one and has the next event.
    pub(crate) fn push(&mut self, frame: u64, x: u16, y: u16, polarity: Polarity) {
        self.fill_to(frame);
        self.events.push([x, y | if polarity.is_on() { ON } else { 0 }]);
        let count = self.events.len() as u64;
        if let Some(end) = self.ends.last_mut() {
            *end = count;
        }
    }

    /// Appends frames without events up to `frame`, if there are fewer.
    pub(crate) fn fill_to(&mut self, frame: u64) {
        let frames = usize::try_from(frame).unwrap_or(usize::MAX).saturating_add(1);
        if self.ends.len() < frames {
            self.ends.resize(frames, self.events.len() as u64);
        }
    }

    /// The events of `frames`, whose indices count from the first of them; frames behind the last
    /// one have none.
    pub(crate) fn events(&self, frames: Range<u64>) -> impl Iterator<Item = FrameEvent> + '_ {
        let end = |frame: u64| self.ends.get(frame as usize).or(self.ends.last()).map_or(0, |e| *e);
        let mut start = frames.start.checked_sub(1).map_or(0, end);
        (0..).zip(frames).flat_map(move |(index, frame)| {
            let events = &self.events[start as usize..end(frame) as usize];
            start = end(frame);
            events.iter().map(move |&[x, row]| {
                let polarity = Polarity::from_on(row & ON > 0);
                FrameEvent { frame: index, x, y: row & !ON, polarity }
            })
        })
    }

    /// Bytes of memory.
    pub(crate) fn bytes(&self) -> u64 {
        (size_of::<[u16; 2]>() * self.events.capacity() + size_of::<u64>() * self.ends.capacity())
            as u64
    }

    /// Returns memory that no event needs.
    pub(crate) fn shrink(&mut self) {
        self.events.shrink_to_fit();
        self.ends.shrink_to_fit();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_have_the_events_of_their_frames() {
        let sensor = SensorSize { width: 1280, height: 720 };
        let mut packed = PackedEvents::new(sensor).unwrap();
        packed.push(1, 1279, 719, Polarity::On);
        packed.push(1, 5, 6, Polarity::Off);
        packed.push(4, 0, 0, Polarity::On);
        packed.fill_to(6);
        let of = |frames: Range<u64>| -> Vec<(u32, u16, u16, bool)> {
            let events = packed.events(frames);
            events.map(|e| (e.frame, e.x, e.y, e.polarity.is_on())).collect()
        };
        assert_eq!(of(0..2), [(1, 1279, 719, true), (1, 5, 6, false)]);
        assert_eq!(of(1..5), [(0, 1279, 719, true), (0, 5, 6, false), (3, 0, 0, true)]);
        assert_eq!(of(2..4), []);
        assert_eq!(of(4..9), [(0, 0, 0, true)]);
        assert_eq!(of(7..9), []);
        packed.shrink();
        // Three events of 4 bytes, and the ends of seven frames.
        assert_eq!(packed.bytes(), 3 * 4 + 7 * 8);
        // A row shares its 16 bits with the polarity.
        assert!(PackedEvents::new(SensorSize { width: 1, height: 32_769 }).is_none());
    }
}
