//! A framed stream of events of our own, for sockets, pipes and files: ten lines of any language
//! write it.
//!
//! Fields are little-endian, times microseconds. A stream begins with 16 bytes:
//!
//! | offset | type | meaning |
//! |---|---|---|
//! | 0 | 8 bytes | `EVPOSE1` and a line feed |
//! | 8 | `u16` | columns of the sensor |
//! | 10 | `u16` | rows of the sensor, at most 32,768 |
//! | 12 | 4 bytes | 0 |
//!
//! Then come packets, each of 16 bytes and its events, until the stream ends. Events are in the
//! order of time; a packet without any says that its sender lives.
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
//! In C, on a little-endian machine:
//!
//! ```c
//! uint16_t size[4] = {346, 260, 0, 0};
//! fwrite("EVPOSE1\n", 1, 8, out);
//! fwrite(size, 2, 4, out);
//! while (read_camera(&events, &count)) {              /* events[k]: t_us, x, y, on */
//!     int64_t base = events[0].t_us;
//!     fwrite("EVTS", 1, 4, out); fwrite(&count, 4, 1, out); fwrite(&base, 8, 1, out);
//!     for (uint32_t k = 0; k < count; k++) {
//!         uint32_t t = events[k].t_us - base;
//!         uint16_t xy[2] = {events[k].x, events[k].y | events[k].on << 15};
//!         fwrite(&t, 4, 1, out); fwrite(xy, 2, 2, out);
//!     }
//! }
//! ```
//!
//! * [`FramedReader`] reads it from whatever gives bytes, and waits for no more of them than it
//!   needs.
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
