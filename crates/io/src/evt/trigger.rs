//! Edges at the trigger inputs of a camera.

use evpose_core::Micros;

/// An edge at a trigger input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExtTrigger {
    /// Time stamp, on the clock of the events.
    pub t: Micros,
    /// Index of the input.
    pub channel: u8,
    /// Whether the signal rose.
    pub is_rising: bool,
}
