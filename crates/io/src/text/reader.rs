//! Reads a recording line by line.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use evpose_core::SensorSize;

use super::TextFault;
use super::line::{Known, Line, names, parse};
use crate::order::{Ordered, is_time, ordered};
use crate::{IoError, Recording, SensorOrigin};

/// Ample for four numbers and a comment; a longer line is not text, or not events.
const LONGEST_LINE: usize = 4096;

/// Fewer events say nothing of the order of columns.
const LEAST_EVENTS: usize = 200;

/// Reads a file, with `sensor` where it does not state its own. Events outside the sensor, and
/// single ones out of order, are left out and counted.
///
/// # Errors
/// If the file cannot be read, at the first line that is no event, or if the first column is not
/// that of times.
pub fn read(path: &Path, sensor: Option<SensorSize>) -> Result<Recording, IoError> {
    let file = File::open(path).map_err(|e| IoError::file(path, "open", e))?;
    let mut reader = BufReader::with_capacity(1 << 18, file);
    let (mut stated, mut events) = (None, Vec::new());
    let mut known = Known { is_first: true, ..Known::default() };
    let mut is_named = false;
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
        let parsed =
            if length > LONGEST_LINE { Err(TextFault::TooLong) } else { parse(&line, &mut known) };
        match parsed {
            Ok(None) => {}
            Ok(Some(Line::Sensor(size))) if stated.is_none() => stated = Some(size),
            Ok(Some(Line::Sensor(_))) => {
                let (path, fault) = (path.to_owned(), TextFault::Fields(2));
                return Err(IoError::Text { path, line: number, byte, fault, events: 0 });
            }
            Ok(Some(Line::Names)) => is_named = true,
            Ok(Some(Line::Event(event))) => {
                known.is_first = false;
                events.push(event);
            }
            Err(fault) => {
                let (path, events) = (path.to_owned(), events.len());
                return Err(IoError::Text { path, line: number, byte, fault, events });
            }
        }
        byte += length as u64;
    }
    let times = events.iter().map(|event| event.t.0 as f64);
    if !is_named && events.len() >= LEAST_EVENTS && !is_time(&times) {
        let (path, fault) = (path.to_owned(), TextFault::Order);
        return Err(IoError::Text { path, line: 1, byte: 0, fault, events: events.len() });
    }
    let (sensor, sensor_origin) = match (stated, sensor) {
        (Some(stated), _) => (stated, SensorOrigin::Stated),
        (None, Some(given)) => (given, SensorOrigin::Given),
        (None, None) => (crate::open::smallest(&events), SensorOrigin::Inferred),
    };
    let Ordered { stream, rejected, sorted } = ordered(sensor, events);
    Ok(Recording { format: "text", stream, rejected, sorted, sensor_origin })
}

/// Whether the beginning of a file is text whose first line with something on it looks like
/// numbers, or names the columns.
pub(super) fn probe(head: &[u8]) -> bool {
    let printable = |b: &u8| b.is_ascii_graphic() || b.is_ascii_whitespace();
    let lines = head.split(|&b| b == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.filter(|line| !line.is_empty()).find(|line| !line.starts_with(b"#"));
    first.is_some_and(|line| {
        line.iter().all(printable)
            && (matches!(line.first(), Some(b'0'..=b'9' | b'-' | b'+' | b'.'))
                || str::from_utf8(line).is_ok_and(|line| names(line).is_some()))
    })
}
