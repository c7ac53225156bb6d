//! One pass over the records of an `.evc` file: is it valid, and where do its frames begin.

use evpose_core::SensorSize;

use super::{NEW_FRAME, RECORD};

/// A fault of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum EvcFault {
    /// The file has no bytes.
    #[error("the file is empty")]
    Empty,
    /// The first record is not a frame marker.
    #[error("the first record is no frame marker: its polarity is {polarity}, not 255")]
    NoMarker {
        /// Its polarity byte.
        polarity: u8,
    },
    /// A polarity byte without a meaning.
    #[error("polarity {0} is none of 0, 1, 255")]
    Polarity(u8),
    /// An event outside the sensor.
    #[error("event at ({x}, {y}) lies outside the {sensor} sensor")]
    OutsideSensor {
        /// Column.
        x: u16,
        /// Row.
        y: u8,
        /// The sensor.
        sensor: SensorSize,
    },
    /// The file ends inside a record.
    #[error("the file ends {bytes} bytes into a record")]
    Truncated {
        /// How many of the four bytes are there.
        bytes: usize,
    },
    /// The contents differ from what they were when the file was opened.
    #[error("the file has changed since it was opened")]
    Changed,
}

/// Counts over a run of records.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Tally {
    /// Frame markers.
    pub(super) markers: u64,
    /// ON events.
    pub(super) on: u64,
}

impl Tally {
    pub(super) fn add(&mut self, other: Self) {
        self.markers += other.markers;
        self.on += other.on;
    }
}

/// Counts records and checks them, or gives the index and the fault of the first faulty one.
///
/// The loop has no branches, so that it runs at the speed of memory; only a run that is faulty is
/// looked at record by record.
pub(super) fn tally(bytes: &[u8], sensor: SensorSize) -> Result<Tally, (usize, EvcFault)> {
    // In 32 bits each, as wide as a record: the loop becomes one of vectors.
    let (mut markers, mut on, mut unknown, mut columns, mut rows) = (0u32, 0u32, 0u32, 0u32, 0u32);
    for record in bytes.as_chunks::<RECORD>().0 {
        let word = u32::from_le_bytes(*record);
        let polarity = word >> 24;
        let event = u32::from(polarity <= 1);
        let marker = u32::from(polarity == u32::from(NEW_FRAME));
        markers += marker;
        on += u32::from(polarity == 1);
        unknown += 1 - (event | marker);
        // Plus 1, so that the largest is a width or a height; markers count as none.
        columns = columns.max(((word & 0xffff) + 1) * event);
        rows = rows.max((((word >> 16) & 0xff) + 1) * event);
    }
    if unknown > 0 || columns > u32::from(sensor.width) || rows > u32::from(sensor.height) {
        // Something is wrong somewhere: now record by record.
        let records = bytes.as_chunks::<RECORD>().0.iter().enumerate();
        for (index, &record) in records {
            if let Some(fault) = fault(record, sensor) {
                return Err((index, fault));
            }
        }
    }
    Ok(Tally { markers: markers.into(), on: on.into() })
}

fn fault([low, high, y, polarity]: [u8; RECORD], sensor: SensorSize) -> Option<EvcFault> {
    let x = u16::from_le_bytes([low, high]);
    match polarity {
        NEW_FRAME => None,
        0 | 1 if sensor.contains(x, y.into()) => None,
        0 | 1 => Some(EvcFault::OutsideSensor { x, y, sensor }),
        other => Some(EvcFault::Polarity(other)),
    }
}

/// Byte offset of marker number `n` (from 0) in a run of records.
pub(super) fn marker_offset(bytes: &[u8], n: u64) -> Option<usize> {
    let records = bytes.as_chunks::<RECORD>().0.iter().enumerate();
    let mut left = n;
    for (index, record) in records {
        if record[3] == NEW_FRAME {
            if left == 0 {
                return Some(index * RECORD);
            }
            left -= 1;
        }
    }
    None
}
