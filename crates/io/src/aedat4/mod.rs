//! AEDAT 4.0, the recordings of iniVation's cameras: events, frames, inertial samples and triggers.
//!
//! | part | what it is |
//! |---|---|
//! | `#!AER-DAT4.0\r\n` | version line |
//! | `IOHeader` | compression, place of the data table, and an XML that names the streams |
//! | packets | `i32` stream, `i32` size, then a body, compressed as the header says |
//! | `FileDataTable` | compressed alike: place, stream, elements and times of every packet |
//!
//! Header, bodies and table are FlatBuffers behind their `u32` size. Scalars are little-endian,
//! times microseconds of Unix time. The table is missing (its place negative) where a recorder was
//! killed: the packets then reach to the end of the file.
//!
//! * [`Packets`] reads everything a file holds, packet by packet; [`Writer`] writes it.
//! * [`Aedat4Stream`] reads events from a socket or a pipe as they come.
//! * The registry's entry reads and writes one stream of events.
//!
//! LZ4 and Zstandard are read at every level, and written at the fast one. With the Cargo feature
//! `zstd`, Zstandard's C library reads it, a quarter faster; without it, everything is Rust.
//!
//! # Source
//! <https://docs.inivation.com/software/software-advanced-usage/file-formats/aedat-4.0.html>, and files
//! written by dv-processing 2.0.4.

mod build;
mod compression;
mod events;
mod flat;
mod header;
#[cfg(feature = "zstd")]
mod libzstd;
mod lz4;
mod packet;
mod packets;
mod source;
mod stream;
mod table;
mod walk;
mod writer;
mod xml;

pub use compression::Compression;
pub(crate) use compression::Inflater;
pub use header::{Stream, StreamKind};
pub use packet::{
    Aedat4Packet, Content, Depth, Frame, ImuSample, PixelFormat, Trigger, TriggerKind,
};
pub use packets::Packets;
pub use stream::{Aedat4Stream, SNIFF_BYTES, is_stream};
pub use writer::Writer;

use crate::open::{Format, no_labels};

/// The version line.
const MAGIC: &[u8; 14] = b"#!AER-DAT4.0\r\n";

/// The registry's entry.
pub(crate) const FORMAT: Format = Format {
    name: "aedat4",
    summary: "AEDAT 4.0 of iniVation (DV): LZ4, Zstandard or plain packets; written with LZ4",
    endings: &[".aedat4"],
    probe: |head| head.starts_with(MAGIC),
    open: source::open,
    create: Some(writer::create),
    labels: no_labels,
};

/// The version of another AEDAT file that begins like this.
pub(crate) fn other_version(head: &[u8]) -> Option<&str> {
    let line = head.strip_prefix(b"#!AER-DAT")?.split(|b| b"\r\n".contains(b)).next()?;
    str::from_utf8(line).ok().filter(|version| (1..=8).contains(&version.len()))
}

#[cfg(test)]
mod tests;
