//! Pulses at external pins.

use std::io::Read;
use std::path::Path;

use evpose_core::Micros;

use super::decoder::Records;
use super::header::{Recorder, bytes_at};
use crate::{Input, IoError, OpenOptions};

/// A pulse at an external pin of a camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SpecialEvent {
    /// Time stamp, on the clock of the events.
    pub t: Micros,
    /// The address as it is in the file. Of a DAVIS, its lowest 10 bits are the kind of pulse (2 is
    /// a falling edge, 3 a rising one, 4 a pulse) or, with several cameras, the camera.
    pub address: u32,
}

/// Reads the special events of a file, in its order.
///
/// DHP19 marks a movement with them: of three or five, the first is its beginning and the last its
/// end; of one, it is the nearer of the two; two or four are pulses near one end; there may be
/// none.
///
/// # Errors
/// If the file cannot be read, is no AEDAT 1.0 or 2.0, or is cut within a record.
pub fn special_events(
    path: impl AsRef<Path>,
    options: &OpenOptions,
) -> Result<Vec<SpecialEvent>, IoError> {
    read(Input::file(path)?, options)
}

/// As [`special_events`], from a file that is open already, or from memory.
pub(super) fn read(mut input: Input, options: &OpenOptions) -> Result<Vec<SpecialEvent>, IoError> {
    if !(super::FORMAT.probe)(&input.head(16)?) {
        return Err(IoError::UnknownFormat {
            path: input.path,
            known: super::FORMAT.name.to_owned(),
        });
    }
    let recorder = Recorder::read(&mut input, options)?;
    let mut records = Records::new(&recorder);
    let mut bytes = bytes_at(&mut input, recorder.start, super::FIRST)?;
    let (mut events, mut start) = (Vec::new(), recorder.start);
    loop {
        let length = records.special_events(&bytes, &mut events);
        // What is left is the begin of a record that the next read completes.
        bytes.drain(..length);
        start += length as u64;
        let room = super::FIRST as u64;
        let read = (&mut input.bytes).take(room).read_to_end(&mut bytes);
        if read.map_err(|e| IoError::file(&input.path, "read", e))? == 0 {
            break;
        }
    }
    if !bytes.is_empty() && !options.salvage {
        let reason = format!("the file ends {} bytes into a record", bytes.len());
        let damage = IoError::damaged(&input.path, start, reason);
        return Err(damage.behind(events.len() as u64));
    }
    Ok(events)
}
