//! Events column by column, as a file holds them.

use evpose_core::{Event, Micros, Polarity};

/// Events in the order of their file, nothing checked.
///
/// Decoders refill one value batch by batch, so that its memory is allocated once. The four columns
/// are of one length between calls.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Columns {
    /// Time stamps.
    pub t: Vec<Micros>,
    /// Columns of pixels, 0 at the left.
    pub x: Vec<u16>,
    /// Rows of pixels, 0 at the top.
    pub y: Vec<u16>,
    /// Polarities.
    pub polarity: Vec<Polarity>,
}

impl Columns {
    /// Empty columns.
    pub fn new() -> Self {
        Self::default()
    }

    /// Count of events.
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// Removes all events and keeps the memory.
    pub fn clear(&mut self) {
        self.truncate(0);
    }

    /// Keeps the first `length` events.
    pub fn truncate(&mut self, length: usize) {
        self.t.truncate(length);
        self.x.truncate(length);
        self.y.truncate(length);
        self.polarity.truncate(length);
    }

    /// Makes room for `events` further events.
    pub fn reserve(&mut self, events: usize) {
        self.t.reserve(events);
        self.x.reserve(events);
        self.y.reserve(events);
        self.polarity.reserve(events);
    }

    /// Appends all events of `other`.
    pub fn append(&mut self, other: &Self) {
        self.t.extend_from_slice(&other.t);
        self.x.extend_from_slice(&other.x);
        self.y.extend_from_slice(&other.y);
        self.polarity.extend_from_slice(&other.polarity);
    }

    /// Removes the first `count` events.
    ///
    /// # Panics
    /// If there are fewer.
    pub(crate) fn discard_first(&mut self, count: usize) {
        self.t.drain(..count);
        self.x.drain(..count);
        self.y.drain(..count);
        self.polarity.drain(..count);
    }

    /// Moves the first `count` events to the end of `to`.
    ///
    /// # Panics
    /// If there are fewer.
    pub(crate) fn move_first(&mut self, count: usize, to: &mut Self) {
        to.t.extend_from_slice(&self.t[..count]);
        to.x.extend_from_slice(&self.x[..count]);
        to.y.extend_from_slice(&self.y[..count]);
        to.polarity.extend_from_slice(&self.polarity[..count]);
        self.discard_first(count);
    }

    /// Sorts by time; events of one time keep their order.
    pub(crate) fn sort(&mut self) {
        let mut events: Vec<Event> = self.iter().collect();
        events.sort_by_key(|event| event.t);
        self.clear();
        events.into_iter().for_each(|event| self.push(event));
    }

    /// Appends an event.
    pub fn push(&mut self, event: Event) {
        self.t.push(event.t);
        self.x.push(event.x);
        self.y.push(event.y);
        self.polarity.push(event.polarity);
    }

    /// Returns the event at `index`.
    ///
    /// # Panics
    /// If `index` is out of range.
    pub fn event(&self, index: usize) -> Event {
        Event {
            t: self.t[index],
            x: self.x[index],
            y: self.y[index],
            polarity: self.polarity[index],
        }
    }

    /// Iterates over the events in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Event> + '_ {
        (0..self.len()).map(|index| self.event(index))
    }
}

impl FromIterator<Event> for Columns {
    fn from_iter<I: IntoIterator<Item = Event>>(events: I) -> Self {
        let mut columns = Self::new();
        events.into_iter().for_each(|event| columns.push(event));
        columns
    }
}
