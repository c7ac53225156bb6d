//! Lines of a `data.log`, taken apart as far as their bytes are there.

use std::collections::BTreeMap;

use evpose_core::Micros;

use super::word::Codec;
use crate::{DecodeFault, DecodeResult};

/// Ample for what comes before a bottle's contents.
const MAX_HEAD: usize = 4096;
/// Beyond 285 years a double no longer resolves microseconds.
pub(super) const MAX_SECONDS: f64 = 9e9;

/// Position of the reader in a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    /// Before its number.
    Begin,
    /// Among decimal integers, with their count per event.
    Decimal(usize),
    /// Among bytes in quotes.
    Packed,
    /// Behind its contents.
    End,
}

/// An event in a bottle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct InBottle {
    /// Index of the bottle among those with events, from 0.
    pub(super) bottle: u64,
    /// Time of the bottle.
    pub(super) time: Micros,
    pub(super) codec: Codec,
    /// Time of the event in ticks, if it has one.
    pub(super) ticks: Option<u32>,
    pub(super) word: u32,
}

/// Decoder of consecutive bottles.
#[derive(Debug, Clone)]
pub(super) struct Bottles {
    place: Place,
    /// Whether words in packed bottles come with times.
    has_ticks: bool,
    bottle: u64,
    time: Micros,
    /// Names of bottles without events, and how many there were.
    pub(super) others: BTreeMap<Box<str>, u64>,
}

impl Bottles {
    pub(super) fn new(has_ticks: bool) -> Self {
        let place = Place::Begin;
        Self { place, has_ticks, bottle: 0, time: Micros(0), others: BTreeMap::new() }
    }

    /// Whether what was read ends within a packed bottle.
    pub(super) fn is_in_packed(&self) -> bool {
        self.place == Place::Packed
    }

    /// Index of the bottle with events that is read, or comes next, from 0.
    pub(super) fn bottle(&self) -> u64 {
        self.bottle
    }

    /// Calls `each` for the whole events in `bytes`; returns the bytes that were read.
    pub(super) fn read(
        &mut self,
        bytes: &[u8],
        is_last: bool,
        mut each: impl FnMut(InBottle),
    ) -> DecodeResult {
        let mut at = 0;
        loop {
            let rest = &bytes[at..];
            let step = match self.place {
                Place::Begin => self.begin(rest, is_last),
                // A state each, since a bottle may be longer than a block.
                Place::Decimal(count) => self.decimal(rest, count, &mut each),
                Place::Packed => self.packed(rest, &mut each),
                Place::End => Ok(self.end(rest)),
            };
            match step {
                // The rest of this place has not come yet.
                Ok(0) => return Ok(at),
                Ok(step) => at += step,
                Err(fault) => return Err(DecodeFault { at: at + fault.at, ..fault }),
            }
        }
    }

    /// Reads what comes before a bottle's contents.
    fn begin(&mut self, rest: &[u8], is_last: bool) -> DecodeResult {
        let blank = rest.len() - rest.trim_ascii_start().len();
        // Blank lines and line ends between bottles.
        if blank > 0 {
            return Ok(blank);
        }
        let head = &rest[..rest.len().min(MAX_HEAD)];
        let end = match head.iter().position(|b| matches!(b, b'(' | b'"' | b'\n')) {
            Some(end) => end,
            None if rest.len() >= MAX_HEAD => return Err(fault("no bottle in this line")),
            None if is_last => head.len(),
            None => return Ok(0),
        };
        let Some((time, name)) = head_of(&rest[..end]) else {
            return Err(match end {
                0 if rest.is_empty() => return Ok(0),
                _ => fault("a bottle begins with its number, its time in seconds and its name"),
            });
        };
        // A time and a word; a label in `LAE` besides, and a velocity of two values in `FLOW`.
        let values_per_event = match name {
            "AE" => 2,
            "LAE" => 3,
            "FLOW" => 4,
            _ => 0,
        };
        if values_per_event == 0 || !matches!(rest.get(end), Some(b'(' | b'"')) {
            *self.others.entry(name.into()).or_default() += 1;
            self.place = Place::End;
            return Ok(end);
        }
        // Brackets may stand before the quote.
        let quoted = rest[end..].iter().position(|b| !matches!(b, b'(' | b' '));
        let Some(inside) = quoted else { return Ok(0) };
        let is_packed = rest[end + inside] == b'"';
        if is_packed && name != "AE" {
            // No program is known to write these, so their layout is unknown.
            *self.others.entry(name.into()).or_default() += 1;
            self.place = Place::End;
            return Ok(end);
        }
        self.time = time;
        self.place = if is_packed { Place::Packed } else { Place::Decimal(values_per_event) };
        Ok(end + if is_packed { inside + 1 } else { 1 })
    }

    /// Reads events of decimal integers.
    fn decimal(
        &mut self,
        rest: &[u8],
        count: usize,
        each: &mut impl FnMut(InBottle),
    ) -> DecodeResult {
        let mut done = 0;
        loop {
            let mut at = done;
            let mut values = [0; 4];
            for (k, value) in values[..count].iter_mut().enumerate() {
                at += rest[at..].iter().take_while(|&&b| b == b' ').count();
                match rest.get(at) {
                    None => return Ok(done),
                    Some(b')') if k == 0 => {
                        (self.place, self.bottle) = (Place::End, self.bottle + 1);
                        return Ok(at + 1);
                    }
                    Some(b')') => {
                        return Err(DecodeFault { at, ..fault("the bottle ends within an event") });
                    }
                    Some(_) => {}
                }
                let Some((integer, length)) = integer(&rest[at..]) else {
                    return Err(DecodeFault { at, ..fault("no number of 32 bits") });
                };
                if at + length == rest.len() {
                    // There may be more digits behind.
                    return Ok(done);
                }
                *value = integer;
                at += length;
            }
            each(InBottle {
                bottle: self.bottle,
                time: self.time,
                codec: Codec::Bits24,
                ticks: Some(values[0]),
                word: values[1],
            });
            done = at;
        }
    }

    /// Reads events in bytes.
    fn packed(&mut self, rest: &[u8], each: &mut impl FnMut(InBottle)) -> DecodeResult {
        // Packed events are one or two words of 32 bits.
        let count = if self.has_ticks { 8 } else { 4 };
        let mut done = 0;
        loop {
            let mut at = done;
            let mut values = [0; 8];
            for (k, value) in values[..count].iter_mut().enumerate() {
                let (byte, length) = match rest[at..] {
                    // An escape may be cut between its two bytes: the event waits for the next
                    // block.
                    [] | [b'\\'] => return Ok(done),
                    [b'"', ..] if k == 0 => {
                        (self.place, self.bottle) = (Place::End, self.bottle + 1);
                        return Ok(at + 1);
                    }
                    [b'"', ..] => {
                        return Err(DecodeFault { at, ..fault("the bottle ends within an event") });
                    }
                    [b'\n', ..] => {
                        return Err(DecodeFault { at, ..fault("the line ends within a bottle") });
                    }
                    [b'\\', escaped, ..] => {
                        let byte = match escaped {
                            b'0' => 0,
                            b'n' => b'\n',
                            b'r' => b'\r',
                            b'"' | b'\\' => escaped,
                            _ => return Err(DecodeFault { at, ..fault("an unknown escape") }),
                        };
                        (byte, 2)
                    }
                    [byte, ..] => (byte, 1),
                };
                *value = byte;
                at += length;
            }
            let [a, b, c, d, e, f, g, h] = values;
            let (first, second) =
                (u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h]));
            each(InBottle {
                bottle: self.bottle,
                time: self.time,
                codec: Codec::Packed,
                ticks: self.has_ticks.then_some(first),
                word: if self.has_ticks { second } else { first },
            });
            done = at;
        }
    }

    /// Skips the rest of a line.
    fn end(&mut self, rest: &[u8]) -> usize {
        match rest.iter().position(|&b| b == b'\n') {
            Some(end) => {
                self.place = Place::Begin;
                end + 1
            }
            None => rest.len(),
        }
    }
}

fn fault(reason: &'static str) -> DecodeFault {
    DecodeFault { at: 0, reason: reason.into() }
}

/// The time and the name at the beginning of a line.
pub(super) fn head_of(head: &[u8]) -> Option<(Micros, &str)> {
    let mut words = str::from_utf8(head).ok()?.split_ascii_whitespace();
    words.next()?.parse::<i64>().ok()?;
    let time = words.next().filter(|time| time.contains('.'))?;
    let time: f64 = time.parse().ok().filter(|s: &f64| s.abs() < MAX_SECONDS)?;
    let is_name = |c: char| c.is_ascii_alphabetic() || c == '[';
    let name = words.next().filter(|name| name.starts_with(is_name))?;
    Some((Micros::from_seconds(time), name))
}

/// An integer of 32 bits and the length of its digits. Some programs write those from 2^31 on as
/// negative.
fn integer(bytes: &[u8]) -> Option<(u32, usize)> {
    let is_negative = bytes.first() == Some(&b'-');
    let begin = usize::from(is_negative);
    let digits = bytes[begin..].iter().take_while(|b| b.is_ascii_digit());
    let (mut value, mut length) = (0_u64, begin);
    for digit in digits {
        value = (10 * value + u64::from(digit - b'0')).min(1 << 40);
        length += 1;
    }
    let fits = value <= if is_negative { 1 << 31 } else { u32::MAX.into() };
    let value = value as u32;
    // The sign alone may be all there is yet.
    let is_whole = length > begin || bytes.len() == begin;
    (fits && is_whole).then_some((if is_negative { value.wrapping_neg() } else { value }, length))
}
