//! `.bin` files of N-MNIST and N-Caltech101 (Orchard et al., "Converting static image datasets to
//! spiking neuromorphic datasets using saccades", Frontiers in Neuroscience 2015).
//!
//! Records of five bytes: column, row, then 24 bits of which the first is the polarity (1 is ON)
//! and the others the time in microseconds, the highest byte first.
//!
//! * A record of row 240 is no event: the reader published with the data adds 2^13 µs to the times
//!   from there on for each of them. None are known in the data; here they are counted and remarked
//!   on.
//! * Times that fall by more than half of their range of 2^23 µs have wrapped around.
//! * A file states nothing, and nothing marks it: it is recognised only where no other format is,
//!   by at least eight records in order of time, at several pixels. The sensor is taken to be the
//!   34x34 of N-MNIST where that holds every event; images of N-Caltech101 differ in size.
//!
//! Files that are written hold what all readers agree on: sensors of up to 256 columns and 240
//! rows, and times from 0 to less than 2^23 µs.

mod writer;

use evpose_core::{Micros, Polarity, SensorSize};

use crate::open::{Format, no_labels};
use crate::time_stamp::{HalfPeriodFall, WraparoundCounter};
use crate::{
    BlockSource, Columns, DecodeResult, Decoder, EventSource, Header, Input, IoError, OpenOptions,
};

/// The registry's entry.
pub(crate) const FORMAT: Format = Format {
    name: "nmnist",
    summary: "records of 5 bytes, as N-MNIST and N-Caltech101",
    endings: &[".bin"],
    probe,
    open,
    create: Some(writer::create),
    labels: no_labels,
};

/// Bytes of a record.
const RECORD: usize = 5;
/// Bits of a time stamp in microseconds.
const TIME_BITS: u32 = 23;
/// Period of the counter of time stamps, in microseconds.
const PERIOD_US: i64 = 1 << TIME_BITS;
/// The row of records that are no events.
const OVERFLOW_ROW: u8 = 240;
/// Offset that such a record adds to all later times, in microseconds.
const OVERFLOW_US: i64 = 1 << 13;
/// Records from which a file can be recognised.
const MIN_RECORDS: usize = 8;
/// The sensor of N-MNIST.
const USUAL: SensorSize = SensorSize { width: 34, height: 34 };

fn open(input: Input, _: &OpenOptions) -> Result<Box<dyn EventSource>, IoError> {
    let header = Header { usual_sensor: Some(USUAL), ..Header::default() };
    Ok(Box::new(BlockSource::new(input, 0, header, Records::default())))
}

/// Records as they follow each other.
#[derive(Debug, Clone)]
struct Records {
    counter: WraparoundCounter,
    overflows: u64,
}

impl Default for Records {
    fn default() -> Self {
        Self { counter: WraparoundCounter::new(TIME_BITS, HalfPeriodFall::StepBack), overflows: 0 }
    }
}

impl Decoder for Records {
    fn decode(&mut self, bytes: &[u8], _: bool, columns: &mut Columns) -> DecodeResult {
        let records = bytes.as_chunks::<RECORD>().0;
        columns.reserve(records.len());
        for &[x, y, high, middle, low] in records {
            let stamp_us = u32::from_be_bytes([0, high & 0x7f, middle, low]);
            let unwrapped_us = self.counter.advance(stamp_us.into());
            // Such a record stands for a wraparound of the clock and is no event.
            if y == OVERFLOW_ROW {
                self.overflows += 1;
                continue;
            }
            columns.t.push(Micros(unwrapped_us + OVERFLOW_US * self.overflows as i64));
            columns.x.push(x.into());
            columns.y.push(y.into());
            columns.polarity.push(Polarity::from_on(high & 0x80 != 0));
        }
        Ok(records.len() * RECORD)
    }

    fn remarks(&self) -> Vec<String> {
        let overflows = (self.overflows > 0).then(|| {
            format!("{} records of row 240 are marks that put times 8.192 ms on", self.overflows)
        });
        let wraparounds = self.counter.wraparounds();
        let wraparounds = (wraparounds > 0)
            .then(|| format!("times wrapped around {wraparounds} times, each after 8.389 s"));
        overflows.into_iter().chain(wraparounds).collect()
    }
}

/// Whether these are records in order of time, at several pixels.
fn probe(head: &[u8]) -> bool {
    let mut columns = Columns::new();
    let mut records = Records::default();
    if records.decode(head, false, &mut columns).is_err() || columns.len() < MIN_RECORDS {
        return false;
    }
    // Of a file that is not seen whole, the last record may be cut.
    let is_whole = head.len().is_multiple_of(RECORD) || head.len() >= 4096;
    let lasts = columns.t[0] < columns.t[columns.len() - 1];
    let moves = columns.x.iter().any(|x| *x != columns.x[0])
        && columns.y.iter().any(|y| *y != columns.y[0]);
    // Unordered bytes go back all the time, which would be wraparounds.
    is_whole && lasts && moves && records.counter.wraparounds() == 0 && columns.t.is_sorted()
}

#[cfg(test)]
mod tests;
