//! EVT 2.1: 64-bit words, each up to 32 events of one row, time and polarity.
//!
//! The upper half is a word of EVT 2.0, whose x is a multiple of 32; the lower half has one bit for
//! each of 32 pixels from there. Of other words it is empty, or more of what they say.
//!
//! Words are little-endian. Cameras older than the GenX320 send the upper half first, each half
//! little-endian, which their headers call `endianness=legacy`.
//!
//! # Source
//! <https://docs.prophesee.ai/stable/data/encoding_formats/evt21.html>; for what that leaves open,
//! OpenEB's `hal/cpp/include/metavision/hal/decoders/evt21`.

use evpose_cpu::vectorize;

use super::SkippedRecords;
use super::evt2::{ON, TIME_HIGH};
use super::time_high::TimeHigh;
use super::words::Words;
use crate::{Columns, DecodeResult, Decoder};

/// Pixels of a word.
pub(super) const PIXELS: u16 = 32;

/// Turns the words of EVT 2.1 into events.
#[derive(Debug, Clone)]
pub struct Evt21Decoder {
    is_legacy: bool,
    time_high: TimeHigh<28>,
    skipped: SkippedRecords,
}

impl Evt21Decoder {
    /// A decoder of words whose upper half comes first, if `is_legacy`, or else last.
    pub fn new(is_legacy: bool) -> Self {
        Self { is_legacy, time_high: TimeHigh::default(), skipped: SkippedRecords::default() }
    }
}

/// Upper and lower half of a word.
#[inline(always)]
pub(super) fn halves(word: [u8; 8], is_legacy: bool) -> (u32, u32) {
    let word = u64::from_le_bytes(word);
    let word = if is_legacy { word.rotate_left(32) } else { word };
    ((word >> 32) as u32, word as u32)
}

impl Decoder for Evt21Decoder {
    fn decode(&mut self, bytes: &[u8], _: bool, columns: &mut Columns) -> DecodeResult {
        let (words, _) = bytes.as_chunks::<8>();
        let mut rest = words;
        // Before the first high time no event has a time. A loop of its own keeps the main one free
        // of it.
        while !self.time_high.is_set()
            && let Some((&word, behind)) = rest.split_first()
        {
            let (upper, mask) = halves(word, self.is_legacy);
            match upper >> 28 {
                0 | ON => self.skipped.untimed += u64::from(mask.count_ones()),
                TIME_HIGH => _ = self.time_high.advance((upper & 0x0FFF_FFFF).into()),
                _ => self.skipped.add_word(upper),
            }
            rest = behind;
        }
        let mut batch = Words::new();
        // Events of the new words begin with the high time that is known.
        batch.set_high(self.time_high.value(), columns);
        vectorize(
            #[inline(always)]
            || {
                for &word in rest {
                    let (upper, mask) = halves(word, self.is_legacy);
                    match upper >> 28 {
                        0 | ON => batch.spread(upper, mask, columns),
                        TIME_HIGH => {
                            let high = self.time_high.advance((upper & 0x0FFF_FFFF).into());
                            batch.set_high(high, columns);
                        }
                        _ => self.skipped.add_word(upper),
                    }
                }
                batch.flush(columns);
            },
        );
        Ok(words.as_flattened().len())
    }

    fn remarks(&self) -> Vec<String> {
        self.skipped.remarks()
    }
}
