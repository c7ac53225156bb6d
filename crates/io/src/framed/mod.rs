//! A framed stream of events of our own, for sockets, pipes and files: ten lines of any language write it.
//!
//! Numbers are little-endian, times microseconds. A stream begins with 16 bytes:
//!
//! | offset | type | meaning |
//! |---|---|---|
//! | 0 | 8 bytes | `EVPOSE1` and a line feed |
//! | 8 | `u16` | columns of the sensor |
//! | 10 | `u16` | rows of the sensor, at most 32,768 |
//! | 12 | 4 bytes | 0 |
//!
//! Then come packets, each of 16 bytes and its events, until the stream ends. Events are in the order of
//! time; a packet without any says that its sender lives.
//!
//! | offset | type | meaning |
//! |---|---|---|
//! | 0 | 4 bytes | `EVTS` |
//! | 4 | `u32` | how many events, at most 4,194,304 |
//! | 8 | `i64` | base of their times, at most 2⁶⁰ from 0 |
//! | 16 + 8 k | `u32` | event number k: its time less the base |
//! | 20 + 8 k | `u16` | its column |
//! | 22 + 8 k | `u16` | its row in the lower 15 bits, 1 for ON in the highest |
//!
//! In Python, without any library:
//!
//! ```python
//! import socket, struct
//! s = socket.create_server(("", 7000)).accept()[0]
//! s.sendall(b"EVPOSE1\n" + struct.pack("<HHI", 346, 260, 0))
//! while events := camera.read():                      # [(t_us, x, y, on), …]
//!     base = events[0][0]
//!     s.sendall(b"EVTS" + struct.pack("<Iq", len(events), base) + b"".join(
//!         struct.pack("<IHH", t - base, x, y | on << 15) for t, x, y, on in events))
//! ```
//!
//! * [`FramedReader`] reads it from whatever gives bytes, and waits for no more of them than it needs.
//! * [`FramedWriter`] writes it.
//! * The registry's entry reads and writes files of it.

mod decoder;
mod layout;
mod reader;
mod source;
mod writer;

pub use decoder::FramedDecoder;
pub use layout::MAGIC;
pub use reader::FramedReader;
pub use writer::FramedWriter;

use crate::open::{Format, no_labels};

/// The registry's entry.
pub(crate) const FORMAT: Format = Format {
    name: "framed",
    summary: "evpose's stream: packets of eight bytes an event, for sockets and pipes, too",
    endings: &[".evs"],
    probe: |head| head.starts_with(MAGIC),
    open: source::open,
    create: Some(source::create),
    labels: no_labels,
};

#[cfg(test)]
mod tests;
