//! EVT 2.0: 32-bit words, one an event, the upper four bits say which.
//!
//! | type | word | bits |
//! |---|---|---|
//! | 0, 1 | **event**, OFF or ON | 27..22: bits 5..0 of the time in µs, 21..11: x, 10..0: y |
//! | 8 | high time | 27..0: bits 33..6 of the time |
//! | A | trigger | 27..22: time, 12..8: channel, 0: edge |
//! | E, F | monitoring data and what goes on with them | |
//!
//! # Source
//! <https://docs.prophesee.ai/stable/data/encoding_formats/evt2.html>; for what that leaves open,
//! OpenEB's `hal/cpp/include/metavision/hal/decoders/evt2`.

use super::SkippedRecords;
use super::batch::Batch;
use super::time_high::TimeHigh;
use crate::{Columns, DecodeResult, Decoder};

/// Events are 0 (OFF) and 1 (ON).
pub(super) const ON: u32 = 0x1;
pub(super) const TIME_HIGH: u32 = 0x8;
pub(super) const EXT_TRIGGER: u32 = 0xA;
pub(super) const OTHERS: u32 = 0xE;
pub(super) const CONTINUED: u32 = 0xF;

/// Bits of the time that are in every word of an event.
pub(super) const LOW_BITS: u32 = 6;

/// Turns the words of EVT 2.0 into events.
#[derive(Debug, Clone, Default)]
pub struct Evt2Decoder {
    time_high: TimeHigh<28>,
    skipped: SkippedRecords,
}

impl SkippedRecords {
    /// Takes a word that is no event, of EVT 2.0 or the upper half of one of EVT 2.1.
    #[cold]
    pub(super) fn add_word(&mut self, word: u32) {
        match word >> 28 {
            EXT_TRIGGER => self.triggers += 1,
            OTHERS | CONTINUED => self.monitoring += 1,
            _ => self.unknown += 1,
        }
    }
}

impl Decoder for Evt2Decoder {
    fn decode(&mut self, bytes: &[u8], _: bool, columns: &mut Columns) -> DecodeResult {
        let (words, _) = bytes.as_chunks::<4>();
        let mut rest = words;
        // Before the first high time no event has a time. A loop of its own keeps the main one free
        // of it.
        while !self.time_high.is_set()
            && let Some((&word, behind)) = rest.split_first()
        {
            let word = u32::from_le_bytes(word);
            match word >> 28 {
                0 | ON => self.skipped.untimed += 1,
                TIME_HIGH => _ = self.time_high.advance((word & 0x0FFF_FFFF).into()),
                _ => self.skipped.add_word(word),
            }
            rest = behind;
        }
        let mut batch = Batch::new();
        for some in rest.chunks(Batch::WORDS) {
            // In a local, which stays in a register: events are many, high times few.
            let mut high = self.time_high.value() << LOW_BITS;
            for &word in some {
                let word = u32::from_le_bytes(word);
                let kind = word >> 28;
                // ON is 1 and OFF 0, so that both are one comparison.
                if kind <= ON {
                    let t = high | i64::from(word >> 22 & 0x3F);
                    let (x, y) = ((word >> 11 & 0x7FF) as u16, (word & 0x7FF) as u16);
                    batch.put(t, x, y, kind == ON, true);
                } else if kind == TIME_HIGH {
                    high = self.time_high.advance((word & 0x0FFF_FFFF).into()) << LOW_BITS;
                } else {
                    self.skipped.add_word(word);
                }
            }
            batch.flush(columns);
        }
        Ok(words.as_flattened().len())
    }

    fn remarks(&self) -> Vec<String> {
        self.skipped.remarks()
    }
}
