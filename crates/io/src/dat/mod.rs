//! Prophesee's DAT files: decoded events, eight bytes each.
//!
//! Lines of `% key value` (see `evt::header`), then a byte for the type of events and one for their
//! size, 8, then little-endian records:
//!
//! | bits | type 0 or 12, events | type 14, edges at trigger inputs |
//! |---|---|---|
//! | 31..0 | time in µs, which begins again at 0 after 71 minutes | likewise |
//! | 45..32 | x | 32: edge |
//! | 59..46 | y | |
//! | 60 | polarity | 63..58: channel |
//!
//! If the header says `% Version 1` or 0, x has 9 bits, y 8 and the polarity is behind them.
//!
//! # Source
//! <https://docs.prophesee.ai/stable/data/file_formats/dat.html>; OpenEB's `event2d.h`,
//! `event_ext_trigger.h` and `dat_tools.py`.

mod reader;
mod writer;

pub use reader::DatDecoder;
pub(crate) use reader::is_dat;

use crate::open::{Format, no_labels};
use crate::time_stamp::{HalfPeriodFall, WraparoundCounter};

/// Bits of the time stamp of a record.
const TIME_BITS: u32 = 32;
/// Bytes of a record.
const RECORD: usize = 8;
/// Types of events: any, of contrast, and edges at trigger inputs.
const EVENT_2D: u8 = 0;
const EVENT_CD: u8 = 12;
const EXT_TRIGGER: u8 = 14;

/// The counter of time stamps, in microseconds.
const fn counter() -> WraparoundCounter {
    WraparoundCounter::new(TIME_BITS, HalfPeriodFall::Wraparound)
}

/// The registry's entry.
pub(crate) const FORMAT: Format = Format {
    name: "dat",
    summary: "Prophesee DAT: eight bytes an event",
    endings: &[".dat"],
    probe: |head| is_dat(&crate::evt::header::Lines::parse(head), head),
    open: reader::open,
    create: Some(writer::create),
    labels: no_labels,
};

#[cfg(test)]
mod tests;
