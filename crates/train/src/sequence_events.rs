//! The events of a sequence: in its file, or in memory as another camera sees them.

use std::ops::Range;

use evpose_core::{Event, EventStream, Micros, SensorSize, TimeWindow};
use evpose_io::{EvcReader, EvcWindow, IoError};
use evpose_repr::FrameEvent;
use evpose_view::{Denoise, ViewAdaptor};

/// Frames that are mapped together.
const CHUNK_FRAMES: u64 = 100;

/// Events of frames of 1 ms.
#[derive(Debug)]
pub(crate) enum SequenceEvents {
    /// In a file.
    Recorded(EvcReader),
    /// In memory; those of frame `k` at `k` milliseconds.
    Seen(EventStream),
}

impl SequenceEvents {
    /// The events of the first `frames` as `adaptor` maps them.
    pub(crate) fn seen(&self, frames: u64, adaptor: &mut ViewAdaptor) -> Result<Self, IoError> {
        let size = adaptor.view().sensor;
        let (mut all, mut mapped) = (EventStream::empty(size), EventStream::empty(size));
        for first in (0..frames).step_by(CHUNK_FRAMES as usize) {
            let events = self.stream(first..(first + CHUNK_FRAMES).min(frames))?;
            adaptor.push(&events, &mut mapped);
            for event in mapped.iter() {
                // In order and on the sensor, as the map writes them.
                let _ = all.push(event);
            }
        }
        Ok(Self::Seen(all))
    }

    /// The events of `frames`, those of frame `k` at `k` milliseconds.
    pub(crate) fn stream(&self, frames: Range<u64>) -> Result<EventStream, IoError> {
        match self {
            Self::Recorded(file) => file.read_stream(frames),
            Self::Seen(events) => Ok(events.slice(window(&frames))),
        }
    }

    /// The events of `frames`, which count from the first of them.
    pub(crate) fn frame_events(&self, frames: Range<u64>) -> Result<Vec<FrameEvent>, IoError> {
        match self {
            Self::Recorded(file) => {
                let mut events = EvcWindow::new();
                file.read_frames(frames, &mut events)?;
                let events = events.events().map(|event| FrameEvent {
                    frame: event.frame,
                    x: event.x,
                    y: event.y,
                    polarity: event.polarity,
                });
                Ok(events.collect())
            }
            Self::Seen(events) => {
                let of_frame = |t: Micros| (t.0.div_euclid(1000) as u64 - frames.start) as u32;
                let range = events.range(window(&frames));
                let event = |i: usize| {
                    let event = events.get(i)?;
                    let (x, y, polarity) = (event.x, event.y, event.polarity);
                    Some(FrameEvent { frame: of_frame(event.t), x, y, polarity })
                };
                Ok(range.filter_map(event).collect())
            }
        }
    }
}

/// Removes events that too few neighbours confirm.
pub(crate) fn keep_confirmed(events: &mut Vec<FrameEvent>, denoise: &Denoise, view: SensorSize) {
    let mut stream = EventStream::empty(view);
    for event in events.iter() {
        let t = Micros(1_000 * i64::from(event.frame));
        // In order and on the sensor, as they were recorded.
        let _ = stream.push(Event { t, x: event.x, y: event.y, polarity: event.polarity });
    }
    denoise.start(view).apply(&mut stream);
    events.clear();
    events.extend(stream.iter().map(|event| FrameEvent {
        frame: (event.t.0 / 1_000) as u32,
        x: event.x,
        y: event.y,
        polarity: event.polarity,
    }));
}

/// The time of frames.
fn window(frames: &Range<u64>) -> TimeWindow {
    let at = |frame: u64| Micros(1_000 * frame as i64);
    TimeWindow { start: at(frames.start), end: at(frames.end) }
}
