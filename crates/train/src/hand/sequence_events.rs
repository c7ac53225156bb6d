//! The events of a sequence: in its `.evc` file, or in memory.

use std::ops::Range;
use std::path::{Path, PathBuf};

use evpose_camera::ViewAdaptor;
use evpose_clean::Denoise;
use evpose_core::{Event, EventStream, Micros, SensorSize, TimeWindow};
use evpose_io::{EvcReader, EvcWindow, IoError, OpenOptions, Windows};
use evpose_repr::FrameEvent;

use crate::hand::packed_events::PackedEvents;

/// Frames that are read together.
const CHUNK_FRAMES: u64 = 100;
/// Ending of files that are not held in memory.
const EVC: &str = "evc";

/// The events of a file that was opened.
pub(crate) enum RecordedEvents {
    /// Frames.
    Evc(EvcReader),
    /// Time stamps, from a file of any other format.
    Stream(Box<Windows>, PathBuf),
}

impl RecordedEvents {
    /// Opens a recording of `sensor`, or of the one that the file says if that is not known.
    pub(crate) fn open(path: &Path, sensor: Option<SensorSize>) -> Result<Self, IoError> {
        if path.extension().is_some_and(|ending| ending == EVC) {
            return Ok(Self::Evc(match sensor {
                Some(sensor) => EvcReader::open_with(path, sensor)?,
                None => EvcReader::open(path)?,
            }));
        }
        let windows = Windows::open(path, &OpenOptions { sensor, ..OpenOptions::default() })?;
        let stated = windows.sensor();
        match sensor.filter(|given| *given != stated) {
            Some(given) => Err(IoError::OtherSensor { path: path.to_owned(), given, stated }),
            None => Ok(Self::Stream(Box::new(windows), path.to_owned())),
        }
    }

    pub(crate) fn sensor(&self) -> SensorSize {
        match self {
            Self::Evc(file) => file.sensor(),
            Self::Stream(windows, _) => windows.sensor(),
        }
    }

    /// Frames of the file; none where its labels alone say how many there are.
    pub(crate) fn frames(&self) -> Option<u64> {
        match self {
            Self::Evc(file) => Some(file.frames()),
            Self::Stream(..) => None,
        }
    }

    /// The events of `frames`, those of frame `k` at `k` milliseconds.
    fn chunk(&mut self, frames: Range<u64>) -> Result<EventStream, IoError> {
        let (windows, path) = match self {
            Self::Evc(file) => return file.read_stream(frames),
            Self::Stream(windows, path) => (windows, path),
        };
        let mut read = EventStream::empty(windows.sensor());
        windows.read(window(&frames), &mut read)?;
        let outside = windows.outside();
        if outside > 0 {
            let reason = format!(
                "{outside} events are outside the sensor: write the recording anew with `evpose convert`"
            );
            return Err(IoError::Stream { path: path.clone(), reason });
        }
        // As an .evc file has them: at the beginning of their frame, the bottom row first.
        let mut events: Vec<Event> = read.iter().collect();
        events.iter_mut().for_each(|event| event.t = start_of(frame_of(event.t)));
        events.sort_by_key(|event| (event.t, std::cmp::Reverse(event.y), event.x));
        let mut stream = EventStream::empty(read.sensor());
        for event in events {
            // In order, and on the sensor as before.
            let _ = stream.push(event);
        }
        Ok(stream)
    }

    /// The events of the first `frames`, in memory unless they are in an `.evc` file and seen as they
    /// are.
    pub(crate) fn into_sequence(
        mut self,
        frames: u64,
        mut adaptor: Option<ViewAdaptor>,
    ) -> Result<SequenceEvents, IoError> {
        // As it is in the file: windows are read when they are needed.
        if adaptor.is_none()
            && let Self::Evc(file) = self
        {
            return Ok(SequenceEvents::Recorded(file));
        }
        let size = adaptor.as_ref().map_or(self.sensor(), |adaptor| adaptor.view().sensor);
        let Some(mut packed) = PackedEvents::new(size) else {
            let reason = format!("frames of {size} have too many rows");
            return Err(IoError::Stream { path: self.path().to_owned(), reason });
        };
        let mut mapped = EventStream::empty(size);
        let mut is_empty = true;
        // In chunks, since packed events take a fraction of the memory.
        for first in (0..frames).step_by(CHUNK_FRAMES as usize) {
            let mut events = self.chunk(first..(first + CHUNK_FRAMES).min(frames))?;
            is_empty &= events.is_empty();
            if let Some(adaptor) = &mut adaptor {
                adaptor.push(&events, &mut mapped);
                std::mem::swap(&mut events, &mut mapped);
            }
            for Event { t, x, y, polarity } in events.iter() {
                packed.push(frame_of(t), x, y, polarity);
            }
            mapped = EventStream::empty(size);
        }
        // No event in the labelled time: the recording's clock may have another unit or origin.
        if is_empty {
            self.check_clock(frames)?;
        }
        packed.fill_to(frames.saturating_sub(1));
        packed.shrink();
        Ok(SequenceEvents::Packed(packed))
    }

    /// Refuses a recording without events in the labelled frames that has some behind them.
    fn check_clock(&mut self, frames: u64) -> Result<(), IoError> {
        let Self::Stream(windows, path) = self else { return Ok(()) };
        let end = start_of(frames);
        if !windows.is_over_at(end)? {
            let begin = windows.next_after(end);
            let reason = format!(
                "no events in the {frames} ms that are labelled from time 0 on, the next at {begin}: \
                 its clock must begin with the labels (evpose convert --zero-time)"
            );
            return Err(IoError::Stream { path: path.clone(), reason });
        }
        Ok(())
    }

    fn path(&self) -> &Path {
        match self {
            Self::Evc(file) => file.path(),
            Self::Stream(_, path) => path,
        }
    }
}

/// Events of frames of 1 ms.
#[derive(Debug)]
pub(crate) enum SequenceEvents {
    /// In a file.
    Recorded(EvcReader),
    /// In memory.
    Packed(PackedEvents),
}

impl SequenceEvents {
    /// The events of `frames`, those of frame `k` at `k` milliseconds.
    pub(crate) fn stream(&self, frames: Range<u64>) -> Result<EventStream, IoError> {
        let packed = match self {
            Self::Recorded(file) => return file.read_stream(frames),
            Self::Packed(packed) => packed,
        };
        let mut stream = EventStream::empty(packed.sensor());
        for event in packed.events(frames.clone()) {
            let t = start_of(frames.start + u64::from(event.frame));
            // In order and on the sensor, as it was packed.
            let _ = stream.push(Event { t, x: event.x, y: event.y, polarity: event.polarity });
        }
        Ok(stream)
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
            Self::Packed(packed) => Ok(packed.events(frames).collect()),
        }
    }

    /// Bytes of the events in memory.
    pub(crate) fn bytes(&self) -> u64 {
        match self {
            Self::Recorded(_) => 0,
            Self::Packed(packed) => packed.bytes(),
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
    TimeWindow { start: start_of(frames.start), end: start_of(frames.end) }
}

/// The time at which a frame begins.
fn start_of(frame: u64) -> Micros {
    Micros(1_000 * frame as i64)
}

/// The frame of a time from 0 on.
fn frame_of(t: Micros) -> u64 {
    t.0.div_euclid(1_000) as u64
}
