//! A packet of events.

use std::time::Instant;

use evpose_core::EventStream;

/// Events that arrived together, and their host time.
#[derive(Debug, Clone)]
pub struct Packet {
    /// Events in time order.
    pub events: EventStream,
    /// Host time of the last event: for a recording, when it was due; for a camera, when it
    /// arrived. Latencies count from here.
    pub host_time: Instant,
    /// Whether time jumped back before this packet: earlier packets belong to another recording.
    pub is_restart: bool,
}
