//! The trait of a cleaner.

use std::fmt::Debug;

use evpose_core::EventStream;

use crate::{CleanError, Mask};

/// Events in, fewer or displaced events out. One instance is one recording.
///
/// A cleaner never makes events, keeps their order, and how a recording is cut into batches does
/// not matter. Batches are in time order and of the sensor it was made for:
/// [`CleanerChain`](crate::CleanerChain) sees to it.
pub trait Cleaner: Debug + Send {
    /// Takes a batch and leaves what is kept of it, and of earlier ones that were held back.
    fn clean(&mut self, events: &mut EventStream);

    /// Appends what is still held back at the end of a recording.
    fn finish(&mut self, _events: &mut EventStream) {}

    /// Whether [`Self::survey`] must see the whole recording before it cleans.
    fn surveys(&self) -> bool {
        false
    }

    /// Looks at a batch of the recording that is to be cleaned.
    fn survey(&mut self, _events: &EventStream) {}

    /// The survey is over.
    ///
    /// # Errors
    /// If what it saw is of no use.
    fn settle(&mut self) -> Result<(), CleanError> {
        Ok(())
    }

    /// Forgets the events and all counts, but not what the survey found.
    fn reset(&mut self);

    /// Counts beyond the number of removed events.
    fn notes(&self) -> Vec<Note> {
        Vec::new()
    }

    /// The pixels that it removes, if that is what it does and they are known.
    fn mask(&self) -> Option<&Mask> {
        None
    }
}

/// A number for the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Note {
    /// Counted quantity.
    pub what: &'static str,
    /// Count.
    pub count: u64,
}
