//! EVT 3.0: 16-bit words of which each changes one thing, the upper four bits say which.
//!
//! | type | word | lower 12 bits |
//! |---|---|---|
//! | 0 | row | 11: camera (0 master, 1 slave), 10..0: y |
//! | 2 | **event** | 11: polarity, 10..0: x |
//! | 3 | base of vectors | 11: polarity, 10..0: x |
//! | 4 | **vector of 12** | one bit an event, the lowest at the base, which moves on by 12 |
//! | 5 | **vector of 8** | likewise, bits 7..0 |
//! | 6 | low time | bits 11..0 of the time in µs |
//! | 8 | high time | bits 23..12 of the time |
//! | A | trigger | 11..8: channel, 0: edge |
//! | 7, E, F | monitoring data and what goes on with them | |
//!
//! Cameras send a row, a time or a base only where it changes, and vectors as 12, 12, 8. The first
//! high time is where a recording begins: what comes before is incomplete. A high time that differs
//! from the one before sets the low time to 0, until its word comes. Times that go back stay so.
//!
//! # Source
//! <https://docs.prophesee.ai/stable/data/encoding_formats/evt3.html>; for what that leaves open,
//! OpenEB's `hal/cpp/include/metavision/hal/decoders/evt3`.

use evpose_cpu::vectorize;

use super::SkippedRecords;
use super::states::{State, States};
use super::time_high::TimeHigh;
use crate::{Columns, DecodeResult, Decoder};

pub(super) const ADDR_Y: u16 = 0x0;
/// The row of a measurement of light, on sensors of the first generation.
const ADDR_Y_OF_LIGHT: u16 = 0x1;
pub(super) const ADDR_X: u16 = 0x2;
pub(super) const VECT_BASE_X: u16 = 0x3;
pub(super) const VECT_12: u16 = 0x4;
pub(super) const VECT_8: u16 = 0x5;
pub(super) const TIME_LOW: u16 = 0x6;
const CONTINUED_4: u16 = 0x7;
pub(super) const TIME_HIGH: u16 = 0x8;
pub(super) const EXT_TRIGGER: u16 = 0xA;
const OTHERS: u16 = 0xE;
const CONTINUED_12: u16 = 0xF;

/// Types that most words have.
const FREQUENT: u32 = 1 << ADDR_Y | 1 << ADDR_X | 1 << TIME_LOW;
/// Bits of a word below its type.
const VALUE: u16 = 0xFFF;
/// The bit above a coordinate: camera, or polarity.
const FLAG: u16 = 0x800;

/// Turns the words of EVT 3.0 into events.
#[derive(Debug, Clone)]
pub struct Evt3Decoder {
    time_high: TimeHigh<12>,
    /// The word of the low time.
    low: u16,
    /// The value of the last word of a row, with the bit of its camera; other than that if it is of
    /// something else.
    row: Option<u16>,
    /// The bit of the camera that is read, once it is known.
    camera: Option<u16>,
    /// Value of the base word, and the columns by which vectors have advanced from it.
    base: Option<(u16, u16)>,
    skipped: SkippedRecords,
}

impl Evt3Decoder {
    /// A decoder of the events of one camera, 0 (master) or 1 (slave); without it, of the one whose
    /// row comes first.
    pub fn new(camera: Option<u8>) -> Self {
        Self {
            time_high: TimeHigh::default(),
            low: 0,
            row: None,
            camera: camera.map(|camera| if camera == 0 { 0 } else { FLAG }),
            base: None,
            skipped: SkippedRecords::default(),
        }
    }

    /// Begins again, of the same camera: what comes is of a camera that was started anew.
    pub(crate) fn restart(&mut self) {
        *self = Self { camera: self.camera, skipped: self.skipped, ..Self::new(None) };
    }

    /// Takes a word before the first row behind the first high time.
    fn begin(&mut self, word: u16) {
        let value = word & VALUE;
        match word >> 12 {
            TIME_HIGH => self.set_high(value),
            ADDR_X => self.count_lost(1),
            VECT_12 => self.count_lost(value.count_ones()),
            VECT_8 => self.count_lost((value & 0xFF).count_ones()),
            VECT_BASE_X | TIME_LOW | ADDR_Y | ADDR_Y_OF_LIGHT if !self.time_high.is_set() => {}
            VECT_BASE_X => self.base = Some((value, 0)),
            TIME_LOW => self.low = value,
            ADDR_Y => {
                self.row = Some(value);
                // The first row decides which camera of a stereo pair is read.
                self.camera = self.camera.or(Some(value & FLAG));
            }
            ADDR_Y_OF_LIGHT => self.skipped.unknown += 1,
            _ => self.other(word),
        }
    }

    fn count_lost(&mut self, events: u32) {
        let lost = match self.time_high.is_set() {
            false => &mut self.skipped.untimed,
            true => &mut self.skipped.unplaced,
        };
        *lost += u64::from(events);
    }

    fn set_high(&mut self, value: u16) {
        let before = self.time_high;
        self.time_high.advance(value.into());
        if before != self.time_high {
            self.low = 0;
        }
    }

    /// Takes a word that does not affect events.
    fn other(&mut self, word: u16) {
        match word >> 12 {
            EXT_TRIGGER => self.skipped.triggers += 1,
            OTHERS | CONTINUED_4 | CONTINUED_12 => self.skipped.monitoring += 1,
            _ => self.skipped.unknown += 1,
        }
    }

    /// Decodes the words between two flushes. `row` and `camera` are known.
    #[inline(always)]
    fn decode_words(&mut self, words: &[[u8; 2]], states: &mut States, columns: &mut Columns) {
        let camera = self.camera.unwrap_or(0);
        let row_before = self.row.unwrap_or(0);
        let mut state = State::new(row_before, self.low);
        states.set_high(self.time_high.value() << 12, columns);
        let (mut rows, mut at) = (0, 0);
        while let Some(&word) = words.get(at) {
            at += 1;
            let word = u16::from_le_bytes(word);
            let kind = word >> 12;
            // One test for the frequent kinds, one match for all others.
            if FREQUENT >> kind & 1 == 1 {
                state = state.with(word);
                // With the bit of the camera clear if it is the one that is read.
                let row = state.row() ^ camera;
                rows |= row;
                states.put(state, (word ^ ADDR_X << 12) & !VALUE | row & FLAG == 0);
                continue;
            }
            match kind {
                VECT_BASE_X => self.base = Some((word & VALUE, 0)),
                VECT_12 | VECT_8 => {
                    // Words of a vector follow each other: they are read together.
                    let vector = vector(&words[at - 1..]);
                    at += vector.words - 1;
                    match &mut self.base {
                        Some((base, moved)) if (state.row() ^ camera) & FLAG == 0 => {
                            let x = (*base & !FLAG).wrapping_add(*moved);
                            let first = (x, *base & FLAG != 0);
                            if vector.words == 3 {
                                states.spread::<4>(state, first, vector.mask, columns);
                            } else {
                                states.spread::<2>(state, first, vector.mask, columns);
                            }
                            *moved = moved.wrapping_add(vector.width);
                        }
                        Some((_, moved)) => {
                            self.skipped.other_camera += u64::from(vector.mask.count_ones());
                            // The base moves, whichever camera's events they are.
                            *moved = moved.wrapping_add(vector.width);
                        }
                        None => self.skipped.unplaced += u64::from(vector.mask.count_ones()),
                    }
                }
                TIME_HIGH => {
                    self.low = state.low();
                    self.set_high(word & VALUE);
                    states.set_high(self.time_high.value() << 12, columns);
                    state = state.with_low(self.low);
                }
                ADDR_Y_OF_LIGHT => {
                    // What comes behind is no event.
                    self.skipped.unknown += 1;
                    state = state.with_row(camera ^ FLAG);
                    rows |= FLAG;
                }
                _ => {
                    self.low = state.low();
                    self.other(word);
                }
            }
        }
        // Counted afterwards, in a second pass: few recordings are of two cameras.
        if rows & FLAG != 0 {
            self.skipped.other_camera += events_of_other_camera(words, row_before ^ camera, camera);
        }
        self.row = Some(state.row() & VALUE);
        self.low = state.low();
    }
}

/// Vectors that are decoded together.
struct Vector {
    mask: u32,
    /// Pixels.
    width: u16,
    words: usize,
}

/// The vectors at the beginning of `words`: three if they are of 12, 12 and 8, else the first.
#[inline(always)]
fn vector(words: &[[u8; 2]]) -> Vector {
    let value = |word: &[u8; 2]| u32::from(u16::from_le_bytes(*word));
    let whole = words.first_chunk::<3>().map(|words| words.each_ref().map(value));
    // Cameras write vectors of 12, 12 and 8 bits in a row: as one mask they cost one step.
    if let Some([a, b, c]) = whole
        && (a >> 12, b >> 12, c >> 12) == (VECT_12.into(), VECT_12.into(), VECT_8.into())
    {
        let mask = a & 0xFFF | (b & 0xFFF) << 12 | (c & 0xFF) << 24;
        return Vector { mask, width: 32, words: 3 };
    }
    let word = words.first().map_or(0, value);
    if word >> 12 == u32::from(VECT_12) {
        Vector { mask: word & 0xFFF, width: 12, words: 1 }
    } else {
        Vector { mask: word & 0xFF, width: 8, words: 1 }
    }
}

/// Counts single events of the other camera; a pass of its own, since few files have any.
fn events_of_other_camera(words: &[[u8; 2]], mut row: u16, camera: u16) -> u64 {
    let mut count = 0;
    for &word in words {
        let word = u16::from_le_bytes(word);
        match word >> 12 {
            ADDR_Y => row = word & VALUE ^ camera,
            ADDR_Y_OF_LIGHT => row = FLAG,
            ADDR_X if row & FLAG != 0 => count += 1,
            _ => {}
        }
    }
    count
}

impl Decoder for Evt3Decoder {
    fn decode(&mut self, bytes: &[u8], is_last: bool, columns: &mut Columns) -> DecodeResult {
        let (words, _) = bytes.as_chunks::<2>();
        let mut rest = words;
        // Until a row is known, no event has a place.
        while self.row.is_none()
            && let Some((&word, behind)) = rest.split_first()
        {
            self.begin(u16::from_le_bytes(word));
            rest = behind;
        }
        let mut states = States::new();
        vectorize(
            #[inline(always)]
            || {
                // In parts: states have places for so many words between two flushes.
                for some in rest.chunks(States::WORDS) {
                    self.decode_words(some, &mut states, columns);
                    states.flush(columns);
                }
            },
        );
        let took = words.as_flattened().len();
        // Some programs end their files with an end of line.
        if is_last && matches!(bytes[took..], [b'\n' | b'\r']) {
            self.skipped.padding += 1;
            return Ok(bytes.len());
        }
        Ok(took)
    }

    fn remarks(&self) -> Vec<String> {
        self.skipped.remarks()
    }
}
