//! `binaryevents.log` in the registry of formats.

use super::ticks::{Tick, TickCounter};
use super::word::{Codec, Words, channel};
use crate::open::{Format, no_labels};
use crate::{
    BlockSource, Columns, DecodeResult, Decoder, EventSource, Header, Input, IoError, OpenOptions,
};

/// The registry's entry.
pub(crate) const FORMAT: Format = Format {
    name: "yarp-binary",
    summary: "binaryevents.log of YARP: times and words of 4 bytes",
    endings: &[".log"],
    probe,
    open,
    create: None,
    labels: no_labels,
};

/// Bytes of a record.
const RECORD: usize = 8;
/// Records from which a file can be recognised.
const MIN_RECORDS: usize = 8;
/// Bytes that a probe sees of a longer file.
const HEAD: usize = 4096;

fn open(mut input: Input, options: &OpenOptions) -> Result<Box<dyn EventSource>, IoError> {
    let first = input.head(HEAD)?;
    let is_right = |(_, word)| channel(word) == 1;
    let words = Words::new(options, records(&first).all(is_right).into());
    let tick = Tick::new(options, None);
    let facts = vec![words.fact(), tick.fact()];
    let header = Header { facts, ..Header::default() };
    let pairs = Pairs { ticks: TickCounter::new(tick), words };
    Ok(Box::new(BlockSource::new(input, 0, header, pairs)))
}

/// Times in ticks, and words.
fn records(bytes: &[u8]) -> impl Iterator<Item = (u32, u32)> {
    bytes.as_chunks::<RECORD>().0.iter().map(|&[a, b, c, d, word @ ..]| {
        (u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes(word))
    })
}

/// Records as they follow each other.
#[derive(Debug, Clone)]
struct Pairs {
    ticks: TickCounter,
    words: Words,
}

impl Decoder for Pairs {
    fn decode(&mut self, bytes: &[u8], _: bool, columns: &mut Columns) -> DecodeResult {
        columns.reserve(bytes.len() / RECORD);
        for (stored, word) in records(bytes) {
            self.words.take(Codec::Bits24, self.ticks.time(stored), word, columns);
        }
        Ok(bytes.len() / RECORD * RECORD)
    }

    fn remarks(&self) -> Vec<String> {
        [self.ticks.remarks(), self.words.remarks()].concat()
    }
}

/// Whether these are events at several pixels, in order of time but for one wrap-around.
fn probe(head: &[u8]) -> bool {
    let (times, words): (Vec<u32>, Vec<u32>) = records(head).unzip();
    // Of a file that is not seen whole, the last record may be cut.
    let is_whole = head.len().is_multiple_of(RECORD) || head.len() >= HEAD;
    let falls = times.windows(2).filter(|pair| pair[1] < pair[0]).count();
    let passes = times.first() != times.last();
    let moves = |bits: u32| words.iter().any(|word| (word ^ words[0]) & bits != 0);
    is_whole
        && times.len() >= MIN_RECORDS
        && falls <= 1
        && passes
        && words.iter().all(|&word| Codec::Bits24.is_event(word))
        && moves(0x7ff << 1)
        && moves(0x3ff << 12)
}
