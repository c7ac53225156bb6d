//! The present of a stream.

use evpose_core::Micros;

/// What time it is, as far as a stream has told.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Clock {
    pub(crate) now: Option<Micros>,
    last_event: Option<Micros>,
}

impl Clock {
    /// Whether events that start at `first` are from before the last ones.
    pub(crate) fn jumps_back(self, first: Micros) -> bool {
        self.last_event.is_some_and(|last| first < last)
    }

    pub(crate) fn see(&mut self, event: Micros) {
        self.last_event = Some(event);
        self.advance(event);
    }

    pub(crate) fn advance(&mut self, t: Micros) {
        self.now = self.now.max(Some(t));
    }
}
