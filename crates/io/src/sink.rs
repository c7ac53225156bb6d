//! Recordings written batch by batch.

use evpose_core::EventStream;

use crate::IoError;

/// A recording that is being written. Its file appears when it is finished; dropped before, it
/// leaves none.
pub trait EventSink {
    /// Appends events, none earlier than the last one before.
    ///
    /// # Errors
    /// If the format cannot hold an event, or if writing fails; the file is then lost.
    fn write(&mut self, events: &EventStream) -> Result<(), IoError>;

    /// Gives the file its name.
    ///
    /// # Errors
    /// If writing fails.
    fn finish(self: Box<Self>) -> Result<(), IoError>;
}
