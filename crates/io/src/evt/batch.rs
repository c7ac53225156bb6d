//! Decoded events on their way into columns.
//!
//! Every word is written to the next place and counted only if it is an event: a branch on the type
//! of a word costs more than that, since no predictor knows it.

use evpose_core::{Micros, Polarity};

use crate::Columns;

/// Places for events.
const PLACES: usize = 2048;
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

    /// Appends the events to `columns`.
    pub(super) fn flush(&mut self, columns: &mut Columns) {
        columns.t.extend_from_slice(&self.t[..self.events]);
        columns.x.extend_from_slice(&self.x[..self.events]);
        columns.y.extend_from_slice(&self.y[..self.events]);
        columns.polarity.extend_from_slice(&self.polarity[..self.events]);
        self.events = 0;
    }
}
