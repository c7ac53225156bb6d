//! Events that arrived together.

use std::time::Instant;

use evpose_core::EventStream;

/// Events that arrived together, and when they happened by the clock of this machine.
#[derive(Debug, Clone)]
pub struct Packet {
    /// In the order of time.
    pub events: EventStream,
    /// When the last of them happened: of a recording, when it was due; of a camera, when they arrived.
    /// Latencies count from here.
    pub happened: Instant,
    /// Whether time jumped back before it: all that came before belongs to another recording.
    pub restarts: bool,
}
