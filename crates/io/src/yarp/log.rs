//! `data.log` in the registry of formats.

use super::bottle::{Bottles, InBottle, head_of};
use super::clock::{Clock, Tick};
use super::word::{Codec, Words, channel};
use crate::open::{Format, no_labels};
use crate::{
    BlockSource, Columns, Decoder, EventSource, Fault, Header, Input, IoError, OpenOptions,
};

/// The registry's entry.
pub(crate) const FORMAT: Format = Format {
    name: "yarp",
    summary: "data.log of YARP: bottles of events, in text or packed",
    endings: &[".log"],
    // Numbers, too, begin lines of events in text, but no name is third in those.
    probe: |head| {
        let first = head.trim_ascii_start().split(|b| matches!(b, b'(' | b'"' | b'\n')).next();
        first.is_some_and(|first| head_of(first).is_some())
    },
    open,
    create: None,
    labels: no_labels,
};

/// Bytes at the beginning that tell what is common to all of a file.
const FIRST: usize = 1 << 20;
/// Numbers in packed bottles that tell whether events have times.
const NUMBERS: usize = 4096;
/// Fewer numbers of a bottle that does not end may ascend by chance.
const LEAST_NUMBERS: usize = 32;
/// A shorter time says nothing about a clock, in seconds.
const LEAST_S: f64 = 0.01;

fn open(mut input: Input, options: &OpenOptions) -> Result<Box<dyn EventSource>, IoError> {
    let first = input.head(FIRST)?;
    let unclear = || IoError::Damaged {
        path: input.path.clone(),
        byte: first.len() as u64,
        reason: "the file ends before it is clear whether its words come with times".into(),
        events: 0,
    };
    let has_ticks = has_ticks(&first).ok_or_else(unclear)?;
    let (cameras, passed) = survey(&first, has_ticks);
    let tick = Tick::new(options, passed);
    let words = Words::new(options, if cameras == 0b10 { 1 } else { 0 });
    let facts = vec![words.fact(), tick.fact()];
    let (bottles, clock) = (Bottles::new(has_ticks), Clock::new(tick));
    let log = Log { bottles, clock, words, without_ticks: 0 };
    let header = Header { facts, ..Header::default() };
    Ok(Box::new(BlockSource::new(input, 0, header, log)))
}

/// Whether words in packed bottles come with times: every second number ascends then, but for a
/// wrap-around, and bottles hold even numbers of them. The beginning of a bottle may be too short to
/// tell.
fn has_ticks(first: &[u8]) -> Option<bool> {
    let (mut numbers, mut bottles) = (Vec::new(), Bottles::new(false));
    // What is damaged is found when it is read.
    let read = bottles.read(first, false, |event| {
        if event.codec == Codec::Packed && numbers.len() < NUMBERS {
            numbers.push((event.bottle, event.word));
        }
    });
    let of_bottles = numbers.chunk_by(|(a, _), (b, _)| a == b);
    // The last bottle may be cut, unless another one has begun.
    let last = numbers.last().map(|(bottle, _)| *bottle);
    let is_behind = bottles.is_in_packed() && last.is_some_and(|last| last < bottles.bottle());
    let whole = of_bottles.clone().count().saturating_sub(usize::from(!is_behind));
    let is_cut = read.is_ok() && bottles.is_in_packed();
    if is_cut && whole == 0 && (1..LEAST_NUMBERS).contains(&numbers.len()) {
        return None;
    }
    let are_even = of_bottles.take(whole).all(|numbers| numbers.len() % 2 == 0);
    let times: Vec<u32> = numbers.iter().step_by(2).map(|(_, number)| *number).collect();
    Some(are_even && times.windows(2).filter(|pair| pair[1] < pair[0]).count() <= 1)
}

/// The cameras of the first events, a bit each, and how many ticks passed in how many seconds between
/// the first bottle and the last.
fn survey(first: &[u8], has_ticks: bool) -> (u8, Option<(f64, f64)>) {
    let mut cameras = 0;
    let mut clock = Clock::new(Tick::new(&OpenOptions::default(), None));
    let (mut begin, mut end): (_, Option<(InBottle, u64)>) = (None, None);
    let _ = Bottles::new(has_ticks).read(first, false, |event| {
        if event.codec.is_event(event.word) {
            cameras |= 1 << channel(event.word);
        }
        if let Some(ticks) = event.ticks {
            let ticks = clock.ticks(ticks);
            begin = begin.or(Some((event, ticks)));
            if end.is_none_or(|(last, _)| last.bottle != event.bottle) {
                end = Some((event, ticks));
            }
        }
    });
    let passed = begin.zip(end).map(|((a, from), (b, to))| {
        (to.saturating_sub(from) as f64, b.time.as_seconds() - a.time.as_seconds())
    });
    (cameras, passed.filter(|(ticks, seconds)| *ticks > 0.0 && *seconds >= LEAST_S))
}

/// Events as they follow each other.
#[derive(Debug, Clone)]
struct Log {
    bottles: Bottles,
    clock: Clock,
    words: Words,
    /// Words that have the time of their bottle.
    without_ticks: u64,
}

impl Decoder for Log {
    fn decode(
        &mut self,
        bytes: &[u8],
        is_last: bool,
        columns: &mut Columns,
    ) -> Result<usize, Fault> {
        let Self { bottles, clock, words, without_ticks } = self;
        bottles.read(bytes, is_last, |event| {
            let t = match event.ticks {
                Some(ticks) => clock.time(ticks),
                None => {
                    *without_ticks += 1;
                    event.time
                }
            };
            words.take(event.codec, t, event.word, columns);
        })
    }

    fn remarks(&self) -> Vec<String> {
        let mut remarks = self.clock.remarks();
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
