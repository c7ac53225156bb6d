//! AEDAT 1.0 and 2.0, as jAER writes them, with the four cameras of DHP19.
//!
//! Lines that begin with `#`, then records, the highest byte first: an address of 4 bytes (2 in
//! version 1.0) and a time of 4 bytes in microseconds. A line `# AEChip: ` names the camera, and
//! with that its sensor and what the bits of an address are:
//!
//! | chip | event | row | column | ON | what else |
//! |---|---|---|---|---|---|
//! | DAVIS | bits 31 and 10 are 0 | 22-30 | 12-21 | bit 11 is 1 | bit 10: special; bit 31: pixels of frames, motion |
//! | DVS128 | bit 15 is 0 | 8-14 | 1-7 | bit 0 is 0 | bit 15: special |
//! | DVS640 | all | 11-20 | 1-10 | bit 0 is 1 | |
//!
//! * Columns and rows are counted from the right and from the bottom in these addresses. Here they
//!   are turned the right way round, as jAER shows them and as DHP19's programs do (`346 - x` and
//!   `260 - y` where the first is 1). Other readers give the coordinates as stored.
//! * Where the chip's name begins with `Multi`, bits 0-3 are the index of the camera. DHP19 is
//!   recorded with `MultiDAVIS346BCameraChip`, 346x260 each.
//! * Of several cameras, [`OpenOptions::camera`] picks one; without it, it is the first in the
//!   file's first records. Skipped records are counted: other cameras, special events, pixels of
//!   frames and samples of motion.
//! * [`special_events`] lists the pulses at external pins, by which DHP19 marks the beginning and
//!   the end of a movement.
//! * Files without a chip (v2e writes such ones) are distinguished by the sensor that the caller
//!   gives, else by the bits that the first addresses use: up to 16 are of a DVS128, up to 21 of a
//!   DVS640, more of a DAVIS, of 240x180 if that holds the first events. The sensor is assumed
//!   then. Chips that are not known here need the caller's sensor.
//! * Times wrap around at 2^32 µs. A stamp that is earlier than the one before is passed on so.
//!
//! Layout of addresses: jAER's `DavisChip`, `DVS128` and `DVS640`, v2e, and the programs published
//! with DHP19.

mod decoder;
mod header;
mod special;

pub use special::{SpecialEvent, special_events};

use crate::open::{Format, no_labels};
use crate::{BlockSource, EventSource, Header, Input, IoError, OpenOptions};
use decoder::Records;
use header::{Recorder, bytes_at};

/// The registry's entry.
pub(crate) const FORMAT: Format = Format {
    name: "aedat2",
    summary: "AEDAT 1.0 and 2.0 of jAER, DHP19's four cameras among them",
    endings: &[".aedat"],
    probe: |head| [b"#!AER-DAT1", b"#!AER-DAT2"].iter().any(|begin| head.starts_with(*begin)),
    open,
    create: None,
    labels: no_labels,
};

/// Bytes of the first records, which decide about cameras.
const FIRST: usize = 1 << 18;

fn open(mut input: Input, options: &OpenOptions) -> Result<Box<dyn EventSource>, IoError> {
    let recorder = Recorder::read(&mut input, options)?;
    let mut records = Records::new(&recorder);
    if recorder.has_cameras {
        records.camera = match options.camera {
            Some(camera) => Some(camera),
            None => {
                // Events of cameras are mixed: the first to have one is read.
                let first = bytes_at(&mut input, recorder.start, FIRST)?;
                Some(Records::new(&recorder).first_camera(&first).unwrap_or(0))
            }
        };
    }
    let header = Header {
        // Without a known chip the size is a guess, which events outside it refute.
        sensor: recorder.is_stated.then_some(recorder.sensor),
        usual_sensor: Some(recorder.sensor),
        facts: recorder.facts(records.camera),
    };
    Ok(Box::new(BlockSource::new(input, recorder.start, header, records)))
}

#[cfg(test)]
mod tests;
