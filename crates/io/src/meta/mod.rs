//! EventHands' `.meta`: the labels of an `.evc` file, one record a frame.
//!
//! Little-endian: an `i32` count `N`, then per frame `N` doubles and the two magic bytes 4, 13.
//! Record `k` is the pose at the *end* of frame `k`. For hands `N` is 12: six articulation
//! coefficients, the wrist's position in metres, its rotation as an axis times an angle in
//! radians.
//!
//! # Source
//! Rudnev et al., *EventHands*, ICCV 2021, supplement, Sec. 4.3.

mod fault;
mod reader;
mod writer;

pub use fault::MetaFault;
pub use reader::MetaReader;
pub use writer::MetaWriter;

/// Bytes of the count at the start.
const HEADER: u64 = 4;
/// The bytes that end every record.
const MAGIC: [u8; 2] = [0x04, 0x0d];

#[cfg(test)]
mod tests;
