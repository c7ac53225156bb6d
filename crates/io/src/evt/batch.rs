//! Decoded events on their way into columns.
//!
//! Every word is written to the next place and counted only if it is an event: a branch on the type
//! of a word costs more than that, since no predictor knows it.

use evpose_core::{Micros, Polarity};

use crate::Columns;

/// Places for events.
const PLACES: usize = 2048;
/// Places that a mask may fill.
const MASK: usize = 32;

/// For every byte, which of its bits are set, from the lowest up; what is behind them is
/// overwritten.
pub(super) static BITS: [[u16; 8]; 256] = bits();

const fn bits() -> [[u16; 8]; 256] {
    let mut table = [[0; 8]; 256];
    let mut byte = 0;
    while byte < 256 {
        let (mut bit, mut count) = (0, 0);
        while bit < 8 {
            if byte >> bit & 1 == 1 {
                table[byte][count] = bit;
                count += 1;
            }
            bit += 1;
        }
        byte += 1;
    }
    table
}

/// Some events, column by column.
pub(super) struct Batch {
    t: [Micros; PLACES],
    x: [u16; PLACES],
    y: [u16; PLACES],
    polarity: [Polarity; PLACES],
    events: usize,
}

impl Batch {
    /// Words of one event at most that may be put between two calls of [`Batch::flush`].
    pub(super) const WORDS: usize = 512;

    pub(super) fn new() -> Self {
        Self {
            t: [Micros(0); PLACES],
            x: [0; PLACES],
            y: [0; PLACES],
            polarity: [Polarity::Off; PLACES],
            events: 0,
        }
    }

    /// Puts an event, if it is one.
    #[inline(always)]
    pub(super) fn put(&mut self, t: i64, x: u16, y: u16, is_on: bool, is_event: bool) {
        // Flushed before the places run out; the remainder spares the bounds check.
        let at = self.events % PLACES;
        self.t[at] = Micros(t);
        self.x[at] = x;
        self.y[at] = y;
        self.polarity[at] = Polarity::from_on(is_on);
        self.events += usize::from(is_event);
    }

    /// Puts events of one time, row and polarity, `x` and what bits of `mask` are set further
    /// right. There are at most `8 * BYTES` bits.
    #[inline(always)]
    pub(super) fn spread<const BYTES: usize>(
        &mut self,
        (t, x, y): (i64, u16, u16),
        is_on: bool,
        mask: u32,
        columns: &mut Columns,
    ) {
        if self.events > PLACES - Self::WORDS - MASK {
            self.flush(columns);
        }
        let at = self.events;
        self.t[at..at + 8 * BYTES].fill(Micros(t));
        self.y[at..at + 8 * BYTES].fill(y);
        self.polarity[at..at + 8 * BYTES].fill(Polarity::from_on(is_on));
        for byte in 0..BYTES {
            let bits = mask >> (8 * byte) & 0xFF;
            let first = x.wrapping_add(8 * byte as u16);
            let places = BITS[bits as usize].map(|bit| first.wrapping_add(bit));
            self.x[self.events..self.events + 8].copy_from_slice(&places);
            self.events += bits.count_ones() as usize;
        }
    }

    /// Appends the events to `columns`.
    pub(super) fn flush(&mut self, columns: &mut Columns) {
        columns.t.extend_from_slice(&self.t[..self.events]);
        columns.x.extend_from_slice(&self.x[..self.events]);
        columns.y.extend_from_slice(&self.y[..self.events]);
        columns.polarity.extend_from_slice(&self.polarity[..self.events]);
        self.events = 0;
    }
}
