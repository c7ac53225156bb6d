//! Event images of measured, simulated and corrected events side by side, frame by frame.

use evpose_core::{EventStream, Micros, TimeWindow};
use serde::{Deserialize, Serialize};

const COLUMNS: usize = 120;

/// Event images of several streams at the same times.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SideBySide {
    /// Names of the streams.
    pub names: Vec<String>,
    /// Columns of an event image.
    pub width: usize,
    /// Rows of an event image.
    pub height: usize,
    /// Length of a frame, microseconds.
    pub frame_us: i64,
    /// The frames in order of time.
    pub frames: Vec<SideBySideFrame>,
}

/// One frame of all streams.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SideBySideFrame {
    /// Start of the frame, microseconds.
    pub t_us: i64,
    /// One event image per stream, row by row, one hexadecimal digit per pixel: four times the
    /// level of ON events plus that of OFF events. Levels: none, one, two or three, more.
    pub images: Vec<String>,
}

impl SideBySide {
    /// Renders `frames` frames of length `frame`, evenly spread over a window.
    ///
    /// All streams have one sensor size; large ones are binned.
    pub fn render(
        streams: &[(&str, &EventStream)],
        window: TimeWindow,
        frame: Micros,
        frames: usize,
    ) -> Option<Self> {
        let size = streams.first()?.1.sensor();
        let side = usize::from(size.width).div_ceil(COLUMNS);
        let (width, height) =
            (usize::from(size.width).div_ceil(side), usize::from(size.height).div_ceil(side));
        let room = (window.length().0 - frame.0).max(0);
        let image = |events: &EventStream, start: Micros| {
            let mut counts = vec![[0u32; 2]; width * height];
            for i in events.range(TimeWindow { start, end: start + frame }) {
                let (x, y) = (usize::from(events.x()[i]) / side, usize::from(events.y()[i]) / side);
                counts[y * width + x][usize::from(events.polarity()[i].is_on())] += 1;
            }
            // Four levels of each polarity: none, one, two or three, more.
            let level = |count: u32| [0, 1, 2, 2][count.min(3) as usize] + u32::from(count > 3);
            // Sixteen combinations fit in one hexadecimal digit: pages stay small.
            let digit = |[off, on]: [u32; 2]| {
                char::from_digit(4 * level(on) + level(off), 16).unwrap_or('0')
            };
            counts.into_iter().map(digit).collect()
        };
        let at = |i: usize| {
            let t_us = window.start.0 + room * i as i64 / (frames.max(2) - 1) as i64;
            let images = streams.iter().map(|(_, events)| image(events, Micros(t_us)));
            SideBySideFrame { t_us, images: images.collect() }
        };
        let names = streams.iter().map(|(name, _)| (*name).to_owned()).collect();
        let frames = (0..frames).map(at).collect();
        Some(Self { names, width, height, frame_us: frame.0, frames })
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Polarity, SensorSize};

    use super::*;

    #[test]
    fn a_digit_encodes_the_events_of_both_polarities() {
        let event = |t, x, polarity| Event { t: Micros(t), x, y: 1, polarity };
        let mut events = vec![event(10, 0, Polarity::On), event(20, 0, Polarity::Off)];
        events.extend((0..4).map(|i| event(30 + i, 2, Polarity::On)));
        events.push(event(900, 1, Polarity::Off));
        let events = EventStream::from_events(SensorSize { width: 3, height: 2 }, events).unwrap();
        let window = TimeWindow { start: Micros(0), end: Micros(1_000) };
        let rendered =
            SideBySide::render(&[("one", &events), ("two", &events)], window, Micros(100), 2)
                .unwrap();
        assert_eq!(rendered.frames[0].images, ["00050c", "00050c"]);
        assert_eq!(rendered.frames[1].images[0], "000010");
        assert_eq!((rendered.frames[0].t_us, rendered.frames[1].t_us), (0, 900));
    }
}
