//! Event and label files, opened by content.
//!
//! * [`evc`], [`meta`]: the sequences of EventHands, events and labels, of any size.

mod error;
pub mod evc;
pub mod meta;
mod positional;

pub use error::IoError;
pub use evc::{EvcEvent, EvcReader, EvcWindow, EvcWriter};
pub use meta::{MetaReader, MetaWriter};
