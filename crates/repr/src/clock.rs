//! The present of a stream.

use evpose_core::Micros;

/// Latest time of a stream: of its last event or of the last `advance`.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct StreamClock {
    pub(crate) now: Option<Micros>,
    last_event: Option<Micros>,
}

impl StreamClock {
    /// Whether events that start at `first` are from before the last ones.
    pub(crate) fn jumps_back(self, first: Micros) -> bool {
        self.last_event.is_some_and(|last| first < last)
    }

    /// Advances to the time stamp of an event.
    pub(crate) fn observe(&mut self, event: Micros) {
        self.last_event = Some(event);
        self.advance(event);
    }

    pub(crate) fn advance(&mut self, t: Micros) {
        self.now = self.now.max(Some(t));
    }
}
