//! A file format of one's own: Event Stream 2.0, whose events take three bytes.
//!
//! ```console
//! $ cargo run --release --example custom_format
//! ```
//! A format of evpose is such a file, plus a line in the registry; see `CONTRIBUTING.md`.
//!
//! # Source
//! <https://github.com/neuromorphic-paris/event_stream>, version 2.0, DVS events.

#![allow(clippy::print_stdout, reason = "a program")]

use anyhow::Result;
use evpose_core::{Event, Micros, Polarity};
use evpose_io::{
    BlockSource, Columns, DecodeFault, Decoder, EventSource, FORMATS, Format, Header, Input,
    IoError, OpenOptions, read_as_in,
};

const EVENT_STREAM: Format = Format {
    name: "event-stream",
    summary: "Event Stream 2.0: three bytes an event",
    endings: &[".es"],
    probe: |head| head.starts_with(MAGIC),
    open,
    create: None,
    labels: |_, _, _| None,
};

/// First bytes of a file; three bytes of version and one of type follow.
const MAGIC: &[u8] = b"Event Stream";
/// Bytes of the header.
const HEADER: usize = 16;
/// Type of streams of DVS events.
const DVS: u8 = 1;

fn open(mut input: Input, _: &OpenOptions) -> Result<Box<dyn EventSource>, IoError> {
    let head = input.head(HEADER)?;
    let (byte, reason) = match head[MAGIC.len()..] {
        [2, _, _, DVS] => {
            let (header, decoder) = (Header::default(), EventStreamDecoder::default());
            return Ok(Box::new(BlockSource::new(input, HEADER as u64, header, decoder)));
        }
        [2, _, _, kind] => (HEADER - 1, format!("a stream of type {kind}, only DVS is read")),
        [major, _, _, _] => (MAGIC.len(), format!("version {major}, only 2 is read")),
        _ => (head.len(), "the file ends within its header".to_owned()),
    };
    Err(IoError::Damaged { path: input.path, byte: byte as u64, reason: reason.into(), events: 0 })
}

/// Time field of overflow records, which stand for 15 µs each, and of reset records.
const OVERFLOW: u8 = 0b1111;

/// Decodes consecutive records. Its state is the index of the file, so it is small.
#[derive(Clone, Default)]
struct EventStreamDecoder {
    t_us: i64,
}

impl Decoder for EventStreamDecoder {
    fn decode(
        &mut self,
        bytes: &[u8],
        _: bool,
        columns: &mut Columns,
    ) -> Result<usize, DecodeFault> {
        let mut at = 0;
        while let Some(&first) = bytes.get(at) {
            if first & 0b1111 == OVERFLOW {
                // A reset record has a count of zero.
                self.t_us += i64::from(OVERFLOW) * i64::from(first >> 4);
                at += 1;
                continue;
            }
            // The rest is less than a record: it comes again with more behind it, or the file is cut.
            let Some(&[a, b, c]) = bytes[at..].first_chunk() else { break };
            self.t_us += i64::from(a & 0b1111);
            columns.push(Event {
                t: Micros(self.t_us),
                x: u16::from(b & 0x3F) << 4 | u16::from(a >> 4),
                y: u16::from(c & 0x7F) << 2 | u16::from(b >> 6),
                polarity: Polarity::from_on(c & 0x80 != 0),
            });
            at += 3;
        }
        Ok(at)
    }
}

fn main() -> Result<()> {
    let formats = [&[EVENT_STREAM][..], FORMATS].concat();
    let mut bytes = [MAGIC, &[2, 0, 0, DVS]].concat();
    // An event at (33, 6) after 3 µs, 2 · 15 µs without one, an event at (34, 6) after 4 µs more.
    bytes.extend([1 << 4 | 3, 2 << 6 | 2, 0x81, 2 << 4 | OVERFLOW, 2 << 4 | 4, 2 << 6 | 2, 0x01]);
    let read = |bytes: &[u8]| {
        let input = Input::memory("two-events.es", bytes.to_vec());
        read_as_in(&formats, input, &OpenOptions::default())
    };
    let recording = read(&bytes)?;
    println!("{}: {} events", recording.format, recording.stream.len());
    for event in recording.stream.iter() {
        println!("{} at ({}, {}), {:?}", event.t, event.x, event.y, event.polarity);
    }
    let error = read(&bytes[..bytes.len() - 1]).map(|_| "no error".to_owned());
    println!("{}", error.unwrap_or_else(|error| error.to_string()));
    Ok(())
}
