//! Reads a recording line by line.

use evpose_core::{SensorSize, bytes_without_bom};

use super::line::{FieldOrder, GEOMETRY, Known, Line, USUAL, fields, names, parse};
use super::{TextFault, quick};
use crate::first_line;
use crate::sniff::{fitting_orders, is_time};
use crate::{
    BlockSource, ColumnNames, Columns, DecodeFault, DecodeResult, Decoder, EventSource, Header,
    Input, IoError, OpenOptions,
};

/// Ample for four values and a comment; a longer line is not text, or not events.
const MAX_LINE: usize = 4096;

/// Bytes by which the order of columns without names is found.
const SNIFFED: usize = 1 << 16;

/// Pixels that no sensor has in a row.
const MAX_SIDE: f64 = 4_096.0;

/// Rows from which on their values show the order of columns.
const MIN_ROWS: usize = 20;

/// Minimal count of events that decides about the order of columns.
const MIN_EVENTS: usize = 200;

/// Opens a text, whose first line may state the sensor.
pub(super) fn open(
    mut input: Input,
    options: &OpenOptions,
) -> Result<Box<dyn EventSource>, IoError> {
    let head = input.head(MAX_LINE)?;
    let begin = head.len() - bytes_without_bom(&head).len();
    let header = Header { sensor: sensor(&head[begin..]), ..Header::default() };
    let mut lines = Lines::default();
    lines.known.unit = options.time_unit;
    lines.known.is_unit_stated = options.time_unit.is_some();
    lines.known.columns = options.columns.clone();
    // Columns that are stated need not be guessed by their values.
    if lines.known.columns == ColumnNames::default() {
        let head = input.head(SNIFFED)?;
        lines.known.order_by_values = order_by_values(&head[begin..]);
    }
    Ok(Box::new(BlockSource::new(input, begin as u64, header, lines)))
}

/// The size in the first line with something on it, if it is one.
fn sensor(head: &[u8]) -> Option<SensorSize> {
    let mut known = Known { is_first: true, ..Known::default() };
    let lines = head.split(|&b| b == b'\n').map(|line| parse(line, &mut known));
    match lines.into_iter().find(|parsed| *parsed != Ok(None))? {
        Ok(Some(Line::Sensor(size))) => Some(size),
        _ => None,
    }
}

/// Decoder of consecutive lines, from the first of a text on.
#[derive(Debug, Clone)]
pub struct Lines {
    known: Known,
    /// Lines so far.
    number: u64,
    has_size: bool,
    is_named: bool,
}

impl Default for Lines {
    fn default() -> Self {
        let known = Known { is_first: true, ..Known::default() };
        Self { known, number: 0, has_size: false, is_named: false }
    }
}

impl Decoder for Lines {
    fn decode(&mut self, bytes: &[u8], is_last: bool, columns: &mut Columns) -> DecodeResult {
        let (mut at, before) = (0, columns.len());
        let is_beginning = self.known.is_first;
        while at < bytes.len() {
            // Usual lines by the quick path; the first unusual one is parsed with all its cases.
            let progress = quick::read(&bytes[at..], &self.known, columns);
            self.number += progress.lines;
            at += progress.bytes;
            let rest = &bytes[at..];
            // The first line that is not usual, or that the block cuts.
            let length = match rest.iter().position(|&b| b == b'\n') {
                Some(end) => end + 1,
                None if is_last || rest.len() > MAX_LINE => rest.len(),
                None => break,
            };
            // A line without its end at the end of a file may be cut.
            let is_open = !rest[..length].ends_with(b"\n");
            self.line(&rest[..length], is_open, columns).map_err(|fault| {
                let reason = format!("line {}: {fault}", self.number);
                DecodeFault { at, reason: reason.into() }
            })?;
            at += length;
        }
        if is_beginning && !self.is_named && columns.len() - before >= MIN_EVENTS {
            let times = columns.t[before..].iter().map(|t| t.0 as f64);
            // Values in another order are valid lines, too; only times that do not rise show it.
            if !is_time(&times) {
                columns.truncate(before);
                let reason = TextFault::Order.to_string().into();
                return Err(DecodeFault { at: 0, reason });
            }
        }
        Ok(at)
    }
}

impl Lines {
    /// Takes a line. An open line may be cut within its last numeral, so it counts only if it ends
    /// in a polarity.
    fn line(&mut self, line: &[u8], is_open: bool, columns: &mut Columns) -> Result<(), TextFault> {
        self.number += 1;
        if line.len() > MAX_LINE {
            return Err(TextFault::TooLong);
        }
        // Asked before parsing, which may learn the order from this line: it may be a cut one.
        let knew_order = self.known.order.is_some();
        match parse(line, &mut self.known)? {
            None => {}
            Some(Line::Sensor(_)) if self.has_size => return Err(TextFault::Fields(2)),
            Some(Line::Sensor(_)) if is_open => return Err(TextFault::Open),
            Some(Line::Sensor(_)) => self.has_size = true,
            Some(Line::Names) => self.is_named = true,
            Some(Line::Event(event)) => {
                let ends_in_polarity =
                    self.known.order.is_some_and(|order| order.places[3] + 1 == order.fields);
                if is_open && !(knew_order && ends_in_polarity) {
                    return Err(TextFault::Open);
                }
                self.known.is_first = false;
                columns.push(event);
            }
        }
        Ok(())
    }
}

/// Whether the beginning of a file is text whose first line with content begins with a numeral, or
/// names the columns, and is not separated by commas or semicolons.
pub(super) fn probe(head: &[u8]) -> bool {
    content(head).is_some_and(|(line, has_geometry)| !has_geometry && !is_separated(line))
}

/// As [`probe`], of tables separated by commas or semicolons, or with a size as Prophesee's programs
/// write it.
pub(super) fn probe_csv(head: &[u8]) -> bool {
    content(head).is_some_and(|(line, has_geometry)| has_geometry || is_separated(line))
}

fn is_separated(line: &[u8]) -> bool {
    line.contains(&b',') || line.contains(&b';')
}

/// Whether a line may name the columns of events, those of names of the caller's among them.
fn may_be_names(line: &str) -> bool {
    let usual = ColumnNames::default();
    let is_name = |field: &str| field.trim_matches('"').starts_with(char::is_alphabetic);
    names(line, &usual).is_some() || line.split([',', ';']).filter(|f| is_name(f)).count() >= 4
}

/// The order of four columns without names, where only one fits the values of the first lines.
fn order_by_values(head: &[u8]) -> Option<FieldOrder> {
    // The head may end within a line, which then says nothing about columns.
    let text = str::from_utf8(&head[..head.iter().rposition(|&b| b == b'\n')?]).ok()?;
    let mut columns: [Vec<f64>; 4] = Default::default();
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or_default();
        let values: Vec<f64> = fields(line).map_while(|field| field.parse().ok()).collect();
        match values.as_slice() {
            // Comments, and the size of the sensor before the first event.
            [] | [_, _] if columns[0].is_empty() => {}
            [..] if values.len() != columns.len() => return None,
            _ => columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value)),
        }
    }
    if columns[0].len() < MIN_ROWS {
        return None;
    }
    let fitting = fitting_orders(&columns);
    let places = *fitting.last()?;
    let span = |place: usize| {
        let times = columns[place].iter().copied();
        times.clone().fold(f64::MIN, f64::max) - times.fold(f64::MAX, f64::min)
    };
    // Where the usual order fits, too, the times of another are longer than any sensor is wide.
    let (usual, found) = (span(USUAL.places[0]), span(places[0]));
    let is_usual = fitting.contains(&USUAL.places) && !(found > MAX_SIDE && found > 10.0 * usual);
    (!is_usual).then_some(FieldOrder { places, fields: columns.len() })
}

/// The first line with content, if it is one of a text of events, and whether one of those before
/// it is of Prophesee's programs.
fn content(head: &[u8]) -> Option<(&[u8], bool)> {
    if first_line::describe(head).is_some() {
        return None;
    }
    let head = bytes_without_bom(head);
    let printable = |b: &u8| b.is_ascii_graphic() || b.is_ascii_whitespace();
    let mut has_geometry = false;
    for line in head.split(|&b| b == b'\n').map(<[u8]>::trim_ascii) {
        match line {
            [] | [b'#', ..] => {}
            // Headers of RAW files have a space there.
            [b'%', next, ..] if next.is_ascii_graphic() => {
                has_geometry |= line.starts_with(GEOMETRY.as_bytes());
            }
            _ => {
                let is_content = line.iter().all(printable)
                    && (matches!(line.first(), Some(b'0'..=b'9' | b'-' | b'+' | b'.'))
                        || str::from_utf8(line).is_ok_and(may_be_names));
                return is_content.then_some((line, has_geometry));
            }
        }
    }
    has_geometry.then_some((&[], true))
}
