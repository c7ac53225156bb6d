//! `data.log` in the registry of formats.

use evpose_core::bytes_without_bom;

use super::bottle::{Bottles, InBottle, head_of};
use super::ticks::{Tick, TickCounter};
use super::word::{Codec, Words, channel};
use crate::open::{Format, no_labels};
use crate::{
    BlockSource, Columns, DecodeResult, Decoder, EventSource, Header, Input, IoError, OpenOptions,
};

/// The registry's entry.
pub(crate) const FORMAT: Format = Format {
    name: "yarp",
    summary: "data.log of YARP: bottles of events, in text or packed",
    endings: &[".log"],
    // Lines of text recordings begin with numerals, too, but their third field is not a name.
    probe: |head| {
        let first = bytes_without_bom(head)
            .trim_ascii_start()
            .split(|b| matches!(b, b'(' | b'"' | b'\n'))
            .next();
        first.is_some_and(|first| head_of(first).is_some())
    },
    open,
    create: None,
    labels: no_labels,
};

/// Bytes at the beginning that decide about the whole file.
const FIRST: usize = 1 << 20;
/// Values of packed bottles that decide whether events have times.
const SAMPLE_VALUES: usize = 4096;
/// Minimal count of values of an unfinished bottle that decides; fewer may ascend by chance.
const MIN_VALUES: usize = 32;
/// Minimal time that decides about the length of a tick, in seconds.
const MIN_ELAPSED_S: f64 = 0.01;

fn open(mut input: Input, options: &OpenOptions) -> Result<Box<dyn EventSource>, IoError> {
    let first = input.head(FIRST)?;
    let (length, first) = (first.len(), bytes_without_bom(&first));
    let unclear = "the file ends before it is clear whether its words come with times";
    let unclear = || IoError::damaged(&input.path, length as u64, unclear);
    let has_ticks = has_ticks(first).ok_or_else(unclear)?;
    let (cameras, elapsed) = survey(first, has_ticks);
    let tick = Tick::new(options, elapsed);
    // A recording of the right camera alone is read without asking for it.
    let words = Words::new(options, if cameras == 0b10 { 1 } else { 0 });
    let facts = vec![words.fact(), tick.fact()];
    let (bottles, ticks) = (Bottles::new(has_ticks), TickCounter::new(tick));
    let log = Log { bottles, ticks, words, without_ticks: 0 };
    let header = Header { facts, ..Header::default() };
    Ok(Box::new(BlockSource::new(input, (length - first.len()) as u64, header, log)))
}

/// Whether words in packed bottles come with times: every second value ascends then, but for a
/// wrap-around, and bottles hold an even count of them. None if the beginning is too short for a
/// decision.
fn has_ticks(first: &[u8]) -> Option<bool> {
    let (mut values, mut bottles) = (Vec::new(), Bottles::new(false));
    // Damage is reported when decoding reaches it.
    let read = bottles.read(first, false, |event| {
        if event.codec == Codec::Packed && values.len() < SAMPLE_VALUES {
            values.push((event.bottle, event.word));
        }
    });
    let of_bottles = values.chunk_by(|(a, _), (b, _)| a == b);
    // The last bottle may be cut, unless another one has begun.
    let last = values.last().map(|(bottle, _)| *bottle);
    let is_behind = bottles.is_in_packed() && last.is_some_and(|last| last < bottles.bottle());
    let whole = of_bottles.clone().count().saturating_sub(usize::from(!is_behind));
    let is_cut = read.is_ok() && bottles.is_in_packed();
    if is_cut && whole == 0 && (1..MIN_VALUES).contains(&values.len()) {
        return None;
    }
    let are_even = of_bottles.take(whole).all(|bottle| bottle.len() % 2 == 0);
    let times: Vec<u32> = values.iter().step_by(2).map(|(_, value)| *value).collect();
    Some(are_even && times.windows(2).filter(|pair| pair[1] < pair[0]).count() <= 1)
}

/// The cameras of the first events, a bit each, and how many ticks passed in how many seconds
/// between the first bottle and the last.
fn survey(first: &[u8], has_ticks: bool) -> (u8, Option<(f64, f64)>) {
    let mut cameras = 0;
    let mut counter = TickCounter::new(Tick::new(&OpenOptions::default(), None));
    let (mut begin, mut end): (_, Option<(InBottle, i64)>) = (None, None);
    let _ = Bottles::new(has_ticks).read(first, false, |event| {
        if event.codec.is_event(event.word) {
            cameras |= 1 << channel(event.word);
        }
        if let Some(ticks) = event.ticks {
            let ticks = counter.ticks(ticks);
            begin = begin.or(Some((event, ticks)));
            // A bottle has one time for all its events: the tick of its first one is compared with
            // it.
            if end.is_none_or(|(last, _)| last.bottle != event.bottle) {
                end = Some((event, ticks));
            }
        }
    });
    let elapsed = begin.zip(end).map(|((a, from), (b, to))| {
        (to.saturating_sub(from) as f64, b.time.as_seconds() - a.time.as_seconds())
    });
    (cameras, elapsed.filter(|(ticks, seconds)| *ticks > 0.0 && *seconds >= MIN_ELAPSED_S))
}

/// Decoder of consecutive events.
#[derive(Debug, Clone)]
struct Log {
    bottles: Bottles,
    ticks: TickCounter,
    words: Words,
    /// Words that have the time of their bottle.
    without_ticks: u64,
}

impl Decoder for Log {
    fn decode(&mut self, bytes: &[u8], is_last: bool, columns: &mut Columns) -> DecodeResult {
        let Self { bottles, ticks, words, without_ticks } = self;
        bottles.read(bytes, is_last, |event| {
            let t = match event.ticks {
                Some(stored) => ticks.time(stored),
                None => {
                    *without_ticks += 1;
                    event.time
                }
            };
            words.take(event.codec, t, event.word, columns);
        })
    }

    fn remarks(&self) -> Vec<String> {
        let mut remarks = self.ticks.remarks();
        remarks.extend(self.words.remarks());
        if self.without_ticks > 0 {
            remarks.push(format!(
                "{} words come without a time and have that of their bottle",
                self.without_ticks
            ));
        }
        for (name, count) in &self.bottles.others {
            remarks.push(format!("{count} bottles {name} are passed over"));
        }
        remarks
    }
}
