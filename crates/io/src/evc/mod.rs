//! EventHands' `.evc`: the events of a simulated sequence, frame by frame, without time stamps.
//!
//! Little-endian records of four bytes, no header:
//!
//! | offset | type | meaning |
//! |---|---|---|
//! | 0 | `u16` | column, 0 at the left |
//! | 2 | `u8` | row, 0 at the top |
//! | 3 | `u8` | 1 = ON, 0 = OFF, 255 = a new frame begins |
//!
//! A frame is 1 ms. The file is `marker, events of frame 0, marker, events of frame 1, …`: it
//! begins with a marker and the last frame has no closing one, so a file cut between two records
//! cannot be distinguished from a whole one. Inside a frame events are in the raster order of the
//! published simulator's frame buffer: bottom row first, columns ascending; a pixel that fires `n`
//! times has `n` identical records.
//!
//! The file does not say how large its sensor is; [`EvcReader::open`] takes the DAVIS240C of the
//! published data.
//!
//! # Source
//! Rudnev et al., *EventHands*, ICCV 2021, supplement, Sec. 4.3.

mod format;
mod reader;
mod scan;
mod window;
mod writer;

pub(crate) use format::FORMAT;
pub use reader::EvcReader;
pub use scan::EvcFault;
pub use window::{EvcEvent, EvcWindow};
pub use writer::EvcWriter;

use evpose_core::{Micros, Polarity};

/// Bytes of a record.
const RECORD: usize = 4;
/// The polarity byte of a frame marker.
const NEW_FRAME: u8 = 255;
/// A frame marker as the published simulator writes it; readers look at the last byte only.
const MARKER: [u8; RECORD] = [0, 0, 0, NEW_FRAME];

/// Duration of a frame.
pub const FRAME: Micros = Micros::MILLISECOND;

fn encode(x: u16, y: u8, polarity: Polarity) -> [u8; RECORD] {
    let [low, high] = x.to_le_bytes();
    [low, high, y, polarity as u8]
}

#[cfg(test)]
mod tests;
