//! `.bin` files of N-MNIST and N-Caltech101 (Orchard et al., "Converting static image datasets to
//! spiking neuromorphic datasets using saccades", Frontiers in Neuroscience 2015).
//!
//! Records of five bytes: column, row, then 24 bits of which the first is the polarity (1 is ON) and
//! the others the time in microseconds, the highest byte first.
//!
//! * A record of row 240 is no event: the reader published with the data adds 2^13 µs to the times
//!   from there on for each of them. None are known in the data; here they are counted and remarked on.
//! * Times that fall by more than half of their range of 2^23 µs have wrapped around.
//! * A file states nothing, and nothing marks it: it is recognised only where no other format is, by
//!   at least eight records in order of time, at several pixels. The sensor is taken to be the
//!   34x34 of N-MNIST where that holds every event; pictures of N-Caltech101 differ in size.
//!
//! Files that are written hold what all readers agree on: sensors of up to 256 columns and 240 rows,
//! and times from 0 to less than 2^23 µs.

mod writer;

use evpose_core::{Micros, Polarity, SensorSize};

use crate::open::{Format, no_labels};
use crate::{
    BlockSource, Columns, Decoder, EventSource, Fault, Header, Input, IoError, OpenOptions,
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
/// Times wrap around here, in microseconds.
const RANGE_US: i64 = 1 << 23;
/// The row of records that are no events.
const OVERFLOW_ROW: u8 = 240;
/// What such a record adds, in microseconds.
const OVERFLOW_US: i64 = 1 << 13;
/// Records from which a file can be recognised.
const LEAST: usize = 8;
/// The sensor of N-MNIST.
const USUAL: SensorSize = SensorSize { width: 34, height: 34 };

fn open(input: Input, _: &OpenOptions) -> Result<Box<dyn EventSource>, IoError> {
    let header = Header { usual_sensor: Some(USUAL), ..Header::default() };
    Ok(Box::new(BlockSource::new(input, 0, header, Records::default())))
}

/// Records as they follow each other.
#[derive(Debug, Clone, Default)]
struct Records {
    /// The latest time as it was written.
    written_us: i64,
    /// What is added to times as they are written.
    ahead_us: i64,
    overflows: u64,
    wraps: u64,
}

impl Decoder for Records {
    fn decode(&mut self, bytes: &[u8], _: bool, columns: &mut Columns) -> Result<usize, Fault> {
        let records = bytes.as_chunks::<RECORD>().0;
        columns.reserve(records.len());
        for &[x, y, high, middle, low] in records {
            let written_us = i64::from(u32::from_be_bytes([0, high & 0x7f, middle, low]));
            if self.written_us - written_us > RANGE_US / 2 {
                self.ahead_us += RANGE_US;
                self.wraps += 1;
            }
            self.written_us = written_us;
            if y == OVERFLOW_ROW {
                self.ahead_us += OVERFLOW_US;
                self.overflows += 1;
                continue;
            }
            columns.t.push(Micros(self.ahead_us + written_us));
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
        let wraps = (self.wraps > 0)
            .then(|| format!("times wrapped around {} times, each after 8.389 s", self.wraps));
        overflows.into_iter().chain(wraps).collect()
    }
}

/// Whether these are records in order of time, at several pixels.
fn probe(head: &[u8]) -> bool {
    let mut columns = Columns::new();
    let mut records = Records::default();
    if records.decode(head, false, &mut columns).is_err() || columns.len() < LEAST {
        return false;
    }
    // Of a file that is not seen whole, the last record may be cut.
    let is_whole = head.len().is_multiple_of(RECORD) || head.len() >= 4096;
    let lasts = columns.t[0] < columns.t[columns.len() - 1];
    let moves = columns.x.iter().any(|x| *x != columns.x[0])
        && columns.y.iter().any(|y| *y != columns.y[0]);
    // Numbers without order go back all the time, which would be time that wraps around.
    is_whole && lasts && moves && records.wraps == 0 && columns.t.is_sorted()
}

#[cfg(test)]
mod tests;
