//! Reads DAT files.

use evpose_core::{Micros, Polarity};

use super::{EVENT_2D, EVENT_CD, EXT_TRIGGER, RECORD, counter};
use crate::evt::SkippedRecords;
use crate::evt::header::Lines;
use crate::source::Shifted;
use crate::time_stamp::WraparoundCounter;
use crate::{
    BlockSource, Columns, DecodeResult, Decoder, EventSource, Input, IoError, OpenOptions,
};

/// First line of most files, behind its key.
const FIRST_LINE: &str = "file containing";

/// Whether a header, and the two bytes behind it, are those of a DAT file.
pub(crate) fn is_dat(lines: &Lines, head: &[u8]) -> bool {
    // RAW files begin with such lines, too, but only theirs state an encoding.
    if lines.is_empty() || lines.get("format").or(lines.get("evt")).is_some() {
        return false;
    }
    let says_so = lines.get("Data").is_some_and(|value| value.starts_with(FIRST_LINE));
    let kind = head.get(lines.length..).and_then(|data| data.first_chunk());
    says_so || matches!(kind, Some([EVENT_2D | EVENT_CD | EXT_TRIGGER, 8]))
}

/// Opens a DAT file.
pub(super) fn open(mut input: Input, _: &OpenOptions) -> Result<Box<dyn EventSource>, IoError> {
    let lines = Lines::read(&mut input)?;
    lines.check_end(&input)?;
    // Behind the text, a byte each states the type and the size of the events.
    let start = lines.length + 2;
    let head = input.head(start)?;
    let data = head.get(lines.length..).unwrap_or_default();
    let version = lines.get("Version").and_then(|version| version.parse().ok());
    let decoder = match *data {
        [kind, size] => DatDecoder::new(kind, size, version),
        _ => None,
    };
    let fault = || {
        let reason = match *data {
            [kind, size] => format!("events of type {kind} and {size} bytes are not read"),
            _ => "the file ends before the type of its events".to_owned(),
        };
        IoError::damaged(&input.path, lines.length as u64, reason)
    };
    let decoder = decoder.ok_or_else(fault)?;
    Ok(Box::new(BlockSource::new(
        input,
        start as u64,
        lines.header(),
        Shifted::new(decoder, lines.t0()),
    )))
}

/// Turns the records of a DAT file into events.
#[derive(Debug, Clone)]
pub struct DatDecoder {
    layout: Layout,
    counter: WraparoundCounter,
    /// Bits of all records so far that are in no field.
    stray: u32,
    triggers: u64,
}

/// Layout of the upper half of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Layout {
    /// x of 14 bits, y of 14, polarity.
    Event,
    /// x of 9 bits, y of 8, polarity.
    Old,
    ExtTrigger,
}

impl DatDecoder {
    /// A decoder of records of this type and size, if such are read. The version is that of the
    /// header; without it, it is the usual 2.
    pub fn new(kind: u8, size: u8, version: Option<u32>) -> Option<Self> {
        let layout = match (kind, version) {
            _ if usize::from(size) != RECORD => return None,
            (EVENT_2D | EVENT_CD, Some(0 | 1)) => Layout::Old,
            (EVENT_2D | EVENT_CD, _) => Layout::Event,
            (EXT_TRIGGER, _) => Layout::ExtTrigger,
            _ => return None,
        };
        Some(Self { layout, counter: counter(), stray: 0, triggers: 0 })
    }

    /// Appends events whose coordinates have `X` and `Y` bits.
    fn events<const X: u32, const Y: u32>(
        &mut self,
        records: &[[u8; RECORD]],
        columns: &mut Columns,
    ) {
        let stamp = |record: &[u8; RECORD]| i64::from(u64::from_le_bytes(*record) as u32);
        let rest = |record: &[u8; RECORD]| (u64::from_le_bytes(*record) >> 32) as u32;
        let mut counter = self.counter;
        columns
            .t
            .extend(records.iter().map(|record| Micros(counter.advance_or_late(stamp(record)))));
        self.counter = counter;
        columns.x.extend(records.iter().map(|record| (rest(record) & ((1 << X) - 1)) as u16));
        columns.y.extend(records.iter().map(|record| (rest(record) >> X & ((1 << Y) - 1)) as u16));
        let is_on = |record| rest(record) >> (X + Y) & 1 == 1;
        columns.polarity.extend(records.iter().map(|record| Polarity::from_on(is_on(record))));
        // Bits beyond the layout are collected, not tested: a branch a record would keep the
        // loop from becoming vectors.
        let all = records.iter().fold(0, |all, record| all | rest(record));
        self.stray |= all >> (X + Y + 1);
    }
}

impl Decoder for DatDecoder {
    fn decode(&mut self, bytes: &[u8], _: bool, columns: &mut Columns) -> DecodeResult {
        let (records, _) = bytes.as_chunks::<RECORD>();
        match self.layout {
            Layout::Event => self.events::<14, 14>(records, columns),
            Layout::Old => self.events::<9, 8>(records, columns),
            Layout::ExtTrigger => self.triggers += records.len() as u64,
        }
        Ok(records.as_flattened().len())
    }

    fn remarks(&self) -> Vec<String> {
        let skipped = SkippedRecords { triggers: self.triggers, ..SkippedRecords::default() };
        let mut remarks = skipped.remarks();
        if self.stray != 0 {
            remarks.push("bits beside the fields of events are set, and passed over".to_owned());
        }
        remarks
    }
}
