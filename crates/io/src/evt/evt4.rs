//! EVT 4.0: 32-bit words as those of EVT 2.0, and vectors of 32 pixels in two of them.
//!
//! | type | word | bits |
//! |---|---|---|
//! | A, B | **event**, OFF or ON | 27..22: bits 5..0 of the time in µs, 21..11: x, 10..0: y |
//! | C, D | **vector**, OFF or ON | likewise; the next word has a bit for each of 32 pixels from x on |
//! | E | high time | 27..0: bits 33..6 of the time |
//! | 9 | trigger | 27..22: time, 12..8: channel, 0: edge |
//! | 6, 7 | monitoring data and what goes on with them | |
//! | F | padding, all bits set | |
//!
//! # Source
//! OpenEB 5, `hal/cpp/include/metavision/hal/decoders/evt4`.

use super::SkippedRecords;
use super::time_high::TimeHigh;
use super::words::Words;
use crate::{Columns, DecodeResult, Decoder};

const OTHERS: u32 = 0x6;
const CONTINUED: u32 = 0x7;
const EXT_TRIGGER: u32 = 0x9;
const OFF: u32 = 0xA;
const ON: u32 = 0xB;
const VECTOR_OFF: u32 = 0xC;
const VECTOR_ON: u32 = 0xD;
const TIME_HIGH: u32 = 0xE;
const PADDING: u32 = 0xF;

/// Turns the words of EVT 4.0 into events.
#[derive(Debug, Clone, Default)]
pub struct Evt4Decoder {
    time_high: TimeHigh<28>,
    skipped: SkippedRecords,
}

impl Decoder for Evt4Decoder {
    fn decode(&mut self, bytes: &[u8], _: bool, columns: &mut Columns) -> DecodeResult {
        let (words, _) = bytes.as_chunks::<4>();
        let (mut batch, mut at) = (Words::new(), 0);
        batch.set_high(self.time_high.value(), columns);
        while let Some(word) = words.get(at) {
            let word = u32::from_le_bytes(*word);
            let kind = word >> 28;
            let mask = match (kind, words.get(at + 1)) {
                (OFF | ON, _) => 1,
                (VECTOR_OFF | VECTOR_ON, Some(mask)) => u32::from_le_bytes(*mask),
                // The mask comes with the next block, or is missing at the end of the file.
                (VECTOR_OFF | VECTOR_ON, None) => break,
                _ => 0,
            };
            at += 1 + usize::from(matches!(kind, VECTOR_OFF | VECTOR_ON));
            match kind {
                OFF..=VECTOR_ON if !self.time_high.is_set() => {
                    self.skipped.untimed += u64::from(mask.count_ones());
                }
                // As words of EVT 2.0, whose type is 0 or 1.
                OFF..=VECTOR_ON => batch.spread(word & 0x1FFF_FFFF, mask, columns),
                TIME_HIGH => {
                    let high = self.time_high.advance((word & 0x0FFF_FFFF).into());
                    batch.set_high(high, columns);
                }
                EXT_TRIGGER => self.skipped.triggers += 1,
                OTHERS | CONTINUED => self.skipped.monitoring += 1,
                PADDING => {}
                _ => self.skipped.unknown += 1,
            }
        }
        batch.flush(columns);
        Ok(4 * at)
    }

    fn remarks(&self) -> Vec<String> {
        self.skipped.remarks()
    }
}

#[cfg(test)]
mod tests {
    use crate::sample::event;
    use crate::{Input, OpenOptions, read_as};

    fn words(words: &[u32]) -> Vec<u8> {
        let head = b"% evt 4.0\n% format EVT4;height=320;width=320\n% end\n";
        [&head[..], &words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<_>>()].concat()
    }

    /// As `decoders_evt4_decoder_gtest.cpp` of OpenEB packs them.
    #[test]
    fn events_and_vectors_are_read_and_cut_ones_are_damage() {
        let cd = |kind: u32, t: u32, x: u32, y: u32| kind << 28 | t << 22 | x << 11 | y;
        let bytes = words(&[
            cd(0xA, 1, 2, 3),
            0xE << 28 | 5,
            cd(0xB, 7, 300, 200),
            u32::MAX,
            cd(0xC, 8, 64, 9),
            1 << 31 | 0b101,
            0x9 << 28 | 1,
            0x6 << 28 | 0x14,
            0x7 << 28 | 99,
            0xE << 28 | 6,
            cd(0xD, 0, 32, 1),
            0b10,
        ]);
        let read = read_as(Input::memory("a.raw", bytes.clone()), &OpenOptions::default()).unwrap();
        let want = [
            event(327, 300, 200, true),
            event(328, 64, 9, false),
            event(328, 66, 9, false),
            event(328, 95, 9, false),
            event(384, 33, 1, true),
        ];
        assert_eq!(read.format, "evt4");
        assert_eq!(read.stream.iter().collect::<Vec<_>>(), want);
        let remarks = read.remarks.join("; ");
        assert!(
            remarks.contains("1 events stand before") && remarks.contains("1 edges"),
            "{remarks}"
        );
        for cut in 1..8 {
            let cut = Input::memory("a.raw", bytes[..bytes.len() - cut].to_vec());
            assert!(read_as(cut, &OpenOptions::default()).unwrap_err().is_damage());
        }
    }
}
