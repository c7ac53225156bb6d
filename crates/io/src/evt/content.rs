//! Detection of the encoding by its words, where no header states it.
//!
//! Conservative: every word must be of a type that the encoding has, time must go forward as it
//! does in recordings, and there must be events behind it. Words of one encoding taken for those of
//! another have any bits where types and times should be.

use super::Encoding;
use super::evt2::{CONTINUED, EXT_TRIGGER, LOW_BITS, ON, OTHERS, TIME_HIGH};
use super::evt3::{self, ADDR_X, ADDR_Y, TIME_LOW, VECT_8, VECT_12, VECT_BASE_X};
use super::evt21::{PIXELS, halves};

/// Bytes of the sample that is inspected.
pub(super) const SAMPLE: usize = 1 << 16;
/// Minimal count of events for a decision.
const MIN_EVENTS: u32 = 8;
/// Maximal share of steps in which time goes back, as it occasionally does in recordings of
/// cameras.
const BACK: f64 = 0.02;
/// Longest silence between two time stamps.
const MAX_SILENCE_US: i64 = 60_000_000;

/// The only encoding that `data`, the beginning of all words, may be of.
pub(super) fn detect(data: &[u8]) -> Option<Encoding> {
    let data = &data[..data.len().min(SAMPLE)];
    let candidates = [
        (is_evt3(data), Encoding::Evt3),
        (is_evt2(data), Encoding::Evt2),
        (is_evt21(data, false), Encoding::Evt21 { is_legacy: false }),
        (is_evt21(data, true), Encoding::Evt21 { is_legacy: true }),
    ];
    let mut compatible = candidates.into_iter().filter(|&(may_be, _)| may_be);
    // Two candidates are no answer: wrong events are worse than a question.
    match (compatible.next(), compatible.next()) {
        (Some((_, encoding)), None) => Some(encoding),
        _ => None,
    }
}

/// As [`detect`], for data without any header, which must begin with a high time.
pub(super) fn detect_without_header(data: &[u8]) -> Option<Encoding> {
    let byte = match detect(data)? {
        Encoding::Evt3 | Encoding::Evt4 => 1,
        Encoding::Evt2 | Encoding::Evt21 { is_legacy: true } => 3,
        Encoding::Evt21 { is_legacy: false } => 7,
    };
    data.get(byte).filter(|&&byte| byte >> 4 == 8).and(detect(data))
}

/// Whether words of EVT 2.1 have their upper half first; none if the words are compatible with both
/// orders.
pub(super) fn is_legacy(data: &[u8]) -> Option<bool> {
    let data = &data[..data.len().min(SAMPLE)];
    match (is_evt21(data, true), is_evt21(data, false)) {
        (true, false) => Some(true),
        (false, true) => Some(false),
        _ => None,
    }
}

/// Statistics of consecutive time stamps.
#[derive(Default)]
struct TimeCourse {
    last: Option<i64>,
    steps: u32,
    back: u32,
    jumps: u32,
    events: u32,
}

impl TimeCourse {
    fn at(&mut self, t: i64) {
        if let Some(last) = self.last {
            self.steps += 1;
            self.back += u32::from(t < last);
            self.jumps += u32::from(t - last > MAX_SILENCE_US);
        }
        self.last = Some(t);
    }

    fn is_plausible(&self) -> bool {
        self.events >= MIN_EVENTS
            && self.jumps == 0
            && f64::from(self.back) <= BACK * f64::from(self.steps)
    }
}

fn is_evt3(data: &[u8]) -> bool {
    let (mut course, mut high, mut has_row, mut has_low) =
        (TimeCourse::default(), None, false, false);
    for &word in data.as_chunks::<2>().0 {
        let word = u16::from_le_bytes(word);
        let value = i64::from(word & 0xFFF);
        match word >> 12 {
            ADDR_Y => has_row = true,
            ADDR_X => course.events += u32::from(has_row && high.is_some()),
            VECT_12 | VECT_8 => course.events += value.count_ones(),
            TIME_LOW => {
                has_low = true;
                if let Some(high) = high {
                    course.at(high << 12 | value);
                }
            }
            evt3::TIME_HIGH => {
                // The counter may wrap around, so that only steps forward are compared. Times that
                // go back are rare in a recording, and every second word of what is none.
                if high.is_some_and(|before| value < before) {
                    course.last = None;
                }
                high = Some(value);
            }
            0x1 | 0x9 | 0xB | 0xC | 0xD => return false,
            VECT_BASE_X.. => {}
        }
    }
    has_row && has_low && high.is_some() && course.is_plausible()
}

fn is_evt2(data: &[u8]) -> bool {
    let words = data.as_chunks::<4>().0;
    are_plausible(words.iter().map(|&word| (u32::from_le_bytes(word), 1)))
}

fn is_evt21(data: &[u8], is_legacy: bool) -> bool {
    let words = data.as_chunks::<8>().0;
    let mut is_aligned = true;
    let words = words.iter().map(|&word| {
        let (upper, mask) = halves(word, is_legacy);
        is_aligned &= upper >> 28 > ON || (upper >> 11 & 0x7FF).is_multiple_of(PIXELS.into());
        (upper, mask.count_ones())
    });
    are_plausible(words) && is_aligned
}

/// Whether words of EVT 2.0, each with its count of events, are plausible.
fn are_plausible(words: impl Iterator<Item = (u32, u32)>) -> bool {
    let (mut course, mut high) = (TimeCourse::default(), None);
    for (word, events) in words {
        match word >> 28 {
            0 | ON => {
                // Low bits alone are no time: events count from the first high bits on.
                if let Some(high) = high {
                    course.events += events;
                    course.at(high << LOW_BITS | i64::from(word >> 22 & 0x3F));
                }
            }
            TIME_HIGH => {
                let value = i64::from(word & 0x0FFF_FFFF);
                // Clocks wrap around: a step back is counted. Random words make too many.
                if high.is_some_and(|before| value < before) {
                    course.back += 1;
                    course.last = None;
                }
                high = Some(value);
            }
            EXT_TRIGGER | OTHERS | CONTINUED => {}
            _ => return false,
        }
    }
    course.is_plausible()
}
