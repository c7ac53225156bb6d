//! The events of a window that slides.

use std::collections::VecDeque;
use std::ops::Range;

use evpose_core::{EventStream, Micros};

use crate::StreamWindow;

/// When an event happened, and the index of its pixel.
pub(crate) type Placed = (Micros, u32);

/// The events of the last `length` of a stream: when, and an index each.
#[derive(Debug, Clone, Default)]
pub(crate) struct Sliding {
    events: VecDeque<Placed>,
}

impl Sliding {
    /// Appends events, with the index of each.
    pub(crate) fn extend(&mut self, events: impl Iterator<Item = Placed>) {
        self.events.extend(events);
    }

    /// Removes the events that are out of the window at `now`, and shows their indices to `gone`.
    pub(crate) fn expire(&mut self, window: &StreamWindow, now: Micros, gone: impl FnMut(u32)) {
        let oldest = Micros(now.0.saturating_sub(window.length_us.into()));
        let out = self.partition_point(|t| t <= oldest);
        self.events.drain(..out).map(|(_, index)| index).for_each(gone);
    }

    /// Count of events.
    pub(crate) fn len(&self) -> usize {
        self.events.len()
    }

    /// Event number `index`.
    pub(crate) fn get(&self, index: usize) -> Option<Placed> {
        self.events.get(index).copied()
    }

    /// The last event.
    pub(crate) fn last(&self) -> Option<Placed> {
        self.events.back().copied()
    }

    /// Events `range.start` up to `range.end` of the window.
    pub(crate) fn range(&self, range: Range<usize>) -> impl Iterator<Item = Placed> + '_ {
        self.events.range(range).copied()
    }

    /// How many events are before the first whose time is not `early`.
    pub(crate) fn partition_point(&self, early: impl Fn(Micros) -> bool) -> usize {
        self.events.partition_point(|&(t, _)| early(t))
    }

    /// The events of the window: the older ones, then the newer ones.
    pub(crate) fn as_slices(&self) -> (&[Placed], &[Placed]) {
        self.events.as_slices()
    }

    pub(crate) fn clear(&mut self) {
        self.events.clear();
    }
}

/// Number of the first event of a push that the window still shows once all of it has been pushed.
pub(crate) fn first_shown(window: &StreamWindow, events: &EventStream) -> usize {
    let Some(&last) = events.t().last() else { return 0 };
    let oldest = Micros(last.0.saturating_sub(window.length_us.into()));
    events.t().partition_point(|&t| t <= oldest)
}
