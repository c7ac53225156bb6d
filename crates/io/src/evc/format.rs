//! `.evc` in the registry of formats.

use std::path::Path;

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};

use super::{EvcFault, EvcWriter, FRAME, NEW_FRAME, RECORD};
use crate::open::{Format, Labels};
use crate::{
    BlockSource, Columns, DecodeFault, DecodeResult, Decoder, EventSink, EventSource, Header,
    Input, IoError, MetaReader, OpenOptions,
};

/// The registry's entry.
pub(crate) const FORMAT: Format = Format {
    name: "evc",
    summary: "EventHands sequence: frames of 1 ms, labels in a .meta file beside it",
    endings: &[".evc"],
    // A marker begins the file; of text, no byte is 255.
    probe: |head| head.first_chunk::<RECORD>().is_some_and(|record| record[3] == NEW_FRAME),
    open,
    create: Some(|path, sensor| Ok(Box::new(EvcSink::new(EvcWriter::create(path, sensor)?)))),
    labels,
};

fn open(input: Input, _: &OpenOptions) -> Result<Box<dyn EventSource>, IoError> {
    let header = Header { usual_sensor: Some(SensorSize::DAVIS240C), ..Header::default() };
    Ok(Box::new(BlockSource::new(input, 0, header, Records { frames: 0 })))
}

/// Records as they follow each other.
#[derive(Debug, Clone)]
struct Records {
    /// Markers so far.
    frames: i64,
}

impl Decoder for Records {
    fn decode(&mut self, bytes: &[u8], _: bool, columns: &mut Columns) -> DecodeResult {
        // Less than a record at the end is left for the next block.
        let records = bytes.as_chunks::<RECORD>().0;
        for (k, &[low, high, y, polarity]) in records.iter().enumerate() {
            let fault = match polarity {
                NEW_FRAME => {
                    // A marker is a millisecond, with or without events.
                    self.frames += 1;
                    continue;
                }
                // Events have no times of their own: theirs is that of the marker before.
                0 | 1 if self.frames > 0 => {
                    columns.push(Event {
                        t: Micros((self.frames - 1) * FRAME.0),
                        x: u16::from_le_bytes([low, high]),
                        y: y.into(),
                        polarity: Polarity::from_on(polarity == 1),
                    });
                    continue;
                }
                0 | 1 => EvcFault::NoMarker { polarity },
                other => EvcFault::Polarity(other),
            };
            return Err(DecodeFault { at: k * RECORD, reason: fault.to_string().into() });
        }
        Ok(records.len() * RECORD)
    }

    fn duration(&self) -> Option<Micros> {
        Some(Micros(self.frames * FRAME.0))
    }
}

/// Writes events into the frames of their times, counted from time 0.
struct EvcSink {
    writer: EvcWriter,
    /// Events of the frame that comes next.
    pending: EventStream,
}

impl EvcSink {
    fn new(writer: EvcWriter) -> Self {
        let pending = EventStream::empty(writer.sensor());
        Self { writer, pending }
    }
}

impl EventSink for EvcSink {
    fn write(&mut self, events: &EventStream) -> Result<(), IoError> {
        self.writer.check_times(events, Micros(0))?;
        for event in events.iter() {
            // Frames without events have their markers too: time is counted by them.
            while event.t.0 >= (self.writer.frames() as i64 + 1) * FRAME.0 {
                self.writer.frame(&self.pending)?;
                self.pending.clear();
            }
            self.pending.push(event).map_err(|fault| self.writer.cannot(fault.to_string()))?;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), IoError> {
        if !self.pending.is_empty() {
            self.writer.frame(&self.pending)?;
        }
        self.writer.finish()
    }
}

fn labels(path: &Path, source: &dyn EventSource, warnings: &mut Vec<String>) -> Option<Labels> {
    let path = path.with_extension("meta");
    if !path.is_file() {
        return None;
    }
    // Labels that cannot be read are a warning: the events beside them are whole.
    let opened = MetaReader::open_prefix(&path);
    let (labels, fault) = match opened {
        Ok((labels, fault)) => (labels, fault),
        Err(fault) => {
            warnings.push(format!("labels: {fault}"));
            return None;
        }
    };
    warnings.extend(fault.map(|fault| format!("labels: {fault}")));
    let (records, values) = (labels.records(), labels.values());
    let frames = source.duration().map_or(0, |lasts| (lasts.0 / FRAME.0) as u64);
    if records != frames {
        warnings.push(format!("{records} labels for {frames} frames: one of the files is cut"));
    }
    Some(Labels { path, records, values })
}
