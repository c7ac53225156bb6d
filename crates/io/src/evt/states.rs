//! Events of EVT 3.0 on their way into columns, each as the words that it follows from: 64 bits.
//!
//! | bits | word |
//! |---|---|
//! | 0 to 15 | of the row |
//! | 16 to 31 | of the column and the polarity |
//! | 48 to 63 | of the low time |
//!
//! One store a word, and no branch on what it is: nothing predicts that. Columns are made of many
//! at once, which vectors do.

use evpose_core::{Micros, Polarity};
use evpose_cpu::vectorize;

use super::mask_bits::put_bits;
use crate::Columns;

/// Places for events.
const PLACES: usize = 2048;
/// Places that a mask may fill.
const MASK: usize = 32;
/// Bit offset of the word of the column.
const X: u32 = 16;
/// Bit offset of the word of the low time.
const LOW: u32 = 48;
/// Coordinates of a word.
const COORDINATE: u64 = 0x7FF;
/// Times of a word.
const TIME: u64 = 0xFFF;
/// The bit of the polarity.
const IS_ON: u32 = X + 11;

/// The last words of each kind.
#[derive(Debug, Clone, Copy)]
pub(super) struct State(u64);

impl State {
    pub(super) fn new(row: u16, low: u16) -> Self {
        Self(u64::from(row) | u64::from(low) << LOW)
    }

    /// With another word of a row (type 0), a column (2) or a low time (6).
    #[inline(always)]
    pub(super) fn with(self, word: u16) -> Self {
        let at = 8 * u32::from(word >> 12 & 6);
        Self(self.0 & !(0xFFFF << at) | u64::from(word) << at)
    }

    /// The word of the row.
    #[inline(always)]
    pub(super) fn row(self) -> u16 {
        self.0 as u16
    }

    /// With another word of the row.
    pub(super) fn with_row(self, row: u16) -> Self {
        Self(self.0 & !0xFFFF | u64::from(row))
    }

    /// The low time.
    #[inline(always)]
    pub(super) fn low(self) -> u16 {
        (self.0 >> LOW & TIME) as u16
    }

    /// With another low time.
    pub(super) fn with_low(self, low: u16) -> Self {
        Self(self.0 & !(0xFFFF << LOW) | u64::from(low) << LOW)
    }
}

/// Some events of one high time.
pub(super) struct States {
    places: [u64; PLACES],
    events: usize,
    /// The high time, microseconds.
    high_us: i64,
}

impl States {
    /// Words of one event at most that may be put between two calls of [`States::flush`].
    pub(super) const WORDS: usize = 512;

    pub(super) fn new() -> Self {
        Self { places: [0; PLACES], events: 0, high_us: 0 }
    }

    /// Sets the high time of all events from here on.
    pub(super) fn set_high(&mut self, high_us: i64, columns: &mut Columns) {
        if high_us != self.high_us {
            self.flush(columns);
            self.high_us = high_us;
        }
    }

    /// Puts an event, if it is one.
    #[inline(always)]
    pub(super) fn put(&mut self, state: State, is_event: bool) {
        // Flushed before the places run out; the remainder spares the bounds check.
        self.places[self.events % PLACES] = state.0;
        self.events += usize::from(is_event);
    }

    /// Puts events of the row and time of `state`, at `x` and what bits of `mask` are set further
    /// right. There are at most `8 * BYTES` bits.
    #[inline(always)]
    pub(super) fn spread<const BYTES: usize>(
        &mut self,
        state: State,
        (x, is_on): (u16, bool),
        mask: u32,
        columns: &mut Columns,
    ) {
        // Room for the largest mask, so that the writing below need not ask.
        if self.events > PLACES - Self::WORDS - MASK {
            self.flush(columns);
        }
        if u64::from(x) + 8 * BYTES as u64 > COORDINATE {
            return self.spread_far(state, (x, is_on), mask, columns);
        }
        let first = state.0 & !(0xFFFF << X) | u64::from(x) << X | u64::from(is_on) << IS_ON;
        put_bits::<BYTES>(first, mask, X, &mut self.places[..], &mut self.events);
    }

    /// The same further right than words go, where no camera has pixels.
    #[cold]
    fn spread_far(
        &mut self,
        state: State,
        (x, is_on): (u16, bool),
        mask: u32,
        columns: &mut Columns,
    ) {
        // Those that wait came first, and these go to the columns at once.
        self.flush(columns);
        for bit in (0..32_u16).filter(|bit| mask >> bit & 1 == 1) {
            columns.t.push(Micros(self.high_us | i64::from(state.low())));
            columns.x.push(x.wrapping_add(bit));
            columns.y.push((state.0 & COORDINATE) as u16);
            columns.polarity.push(Polarity::from_on(is_on));
        }
    }

    /// Appends the events to `columns`.
    #[inline(never)]
    pub(super) fn flush(&mut self, columns: &mut Columns) {
        let (states, high_us) = (&self.places[..self.events], self.high_us);
        vectorize(
            #[inline(always)]
            || {
                // A loop per column vectorises: all have the high bits of the last `set_high`.
                let t = states.iter().map(|state| Micros(high_us | (state >> LOW & TIME) as i64));
                columns.t.extend(t);
                columns.x.extend(states.iter().map(|state| (state >> X & COORDINATE) as u16));
                columns.y.extend(states.iter().map(|state| (state & COORDINATE) as u16));
                let is_on = states.iter().map(|state| Polarity::from_on(state >> IS_ON & 1 == 1));
                columns.polarity.extend(is_on);
            },
        );
        self.events = 0;
    }
}
