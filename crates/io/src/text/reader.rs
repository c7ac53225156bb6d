//! Reads a recording line by line.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use evpose_core::{EventStreamBuilder, SensorSize};

use super::TextFault;
use super::line::{Line, parse};
use crate::{IoError, Recording, SensorOrigin};

/// Ample for four numbers and a comment; a longer line is not text, or not events.
const LONGEST_LINE: usize = 4096;

/// Reads a file, with `sensor` where it does not state its own. Events outside the sensor or out
/// of order are left out and counted.
///
/// # Errors
/// If the file cannot be read, or at the first line that is no event.
pub fn read(path: &Path, sensor: Option<SensorSize>) -> Result<Recording, IoError> {
    let file = File::open(path).map_err(|e| IoError::file(path, "open", e))?;
    let mut reader = BufReader::with_capacity(1 << 18, file);
    let (mut stated, mut unit, mut events) = (None, None, Vec::new());
    let (mut byte, mut number) = (0u64, 0u64);
    let mut line = Vec::with_capacity(LONGEST_LINE);
    loop {
        line.clear();
        let mut limited = (&mut reader).take(LONGEST_LINE as u64 + 1);
        let length =
            limited.read_until(b'\n', &mut line).map_err(|e| IoError::file(path, "read", e))?;
        if length == 0 {
            break;
        }
        number += 1;
        let parsed = if length > LONGEST_LINE {
            Err(TextFault::TooLong)
        } else {
            parse(&line, stated.is_none() && events.is_empty(), &mut unit)
        };
        match parsed {
            Ok(None) => {}
            Ok(Some(Line::Sensor(size))) => stated = Some(size),
            Ok(Some(Line::Event(event))) => events.push(event),
            Err(fault) => {
                let (path, events) = (path.to_owned(), events.len());
                return Err(IoError::Text { path, line: number, byte, fault, events });
            }
        }
        byte += length as u64;
    }
    let (sensor, sensor_origin) = match (stated, sensor) {
        (Some(stated), _) => (stated, SensorOrigin::Stated),
        (None, Some(given)) => (given, SensorOrigin::Given),
        (None, None) => {
            let inside = || events.iter().filter(|e| e.x < u16::MAX && e.y < u16::MAX);
            let width = inside().map(|e| e.x + 1).max().unwrap_or(1);
            let height = inside().map(|e| e.y + 1).max().unwrap_or(1);
            (SensorSize { width, height }, SensorOrigin::Inferred)
        }
    };
    let mut builder = EventStreamBuilder::new(sensor);
    events.into_iter().for_each(|event| builder.push(event));
    let (stream, rejected) = builder.finish();
    Ok(Recording { format: "text", stream, rejected, sensor_origin })
}

/// Whether the beginning of a file is text whose first line with something on it looks like
/// numbers.
pub(super) fn probe(head: &[u8]) -> bool {
    let printable = |b: &u8| b.is_ascii_graphic() || b.is_ascii_whitespace();
    let lines = head.split(|&b| b == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.filter(|line| !line.is_empty()).find(|line| !line.starts_with(b"#"));
    first.is_some_and(|line| {
        line.iter().all(printable) && matches!(line.first(), Some(b'0'..=b'9' | b'-' | b'+' | b'.'))
    })
}
