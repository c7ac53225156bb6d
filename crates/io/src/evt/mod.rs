//! Prophesee's RAW files: the words of a camera as they came, behind a header of `%` lines.
//!
//! Four encodings, distinguished by the header (`% format EVT3;height=720;width=1280`, or `% evt
//! 3.0` of older programs), or by the words where it does not say: [`Evt2Decoder`],
//! [`Evt21Decoder`], [`Evt3Decoder`], [`Evt4Decoder`]. Writers of the first three are [`Evt2Encoder`], [`Evt21Encoder`],
//! [`Evt3Encoder`]. Edges at trigger inputs are no events: they are counted.
//!
//! # Source
//! <https://docs.prophesee.ai/stable/data/file_formats/raw.html>

mod batch;
mod content;
mod encode2;
mod encode21;
mod encode3;
mod encoding;
mod evt2;
mod evt21;
mod evt3;
mod evt4;
mod format;
pub(crate) mod header;
mod mask_bits;
mod skipped;
mod states;
pub mod synthetic;
mod time_high;
mod words;
mod writer;

pub use encode2::Evt2Encoder;
pub use encode3::Evt3Encoder;
pub use encode21::Evt21Encoder;
use encoding::Encoding;
pub use evt2::Evt2Decoder;
pub use evt3::Evt3Decoder;
pub use evt4::Evt4Decoder;
pub use evt21::Evt21Decoder;
pub(crate) use format::{EVT2, EVT3, EVT4, EVT21};
pub(crate) use skipped::SkippedRecords;
pub use time_high::EncodeError;
pub use writer::WordEncoder;

#[cfg(test)]
mod tests;
