//! Reads a stream from whatever gives bytes.

use std::borrow::Cow;
use std::io::{ErrorKind, Read};
use std::path::PathBuf;

use evpose_core::{Micros, SensorSize};

use super::decoder::FramedDecoder;
use super::layout::{HEADER, sensor_of};
use crate::fill::fill;
use crate::open::believed;
use crate::{Columns, DecodeFault, Decoder, IoError};

/// Bytes that wait to be decoded, at most: 32,766 events, about what a second-level cache holds
/// beside the columns they become.
const BUFFER: usize = 1 << 18;

/// A long packet is given in parts: as soon as so many events are there, and those of a buffer more
/// at most.
const ENOUGH: usize = 1 << 16;

/// Packets that came at once are given at once if they begin within so much time: one by one, those
/// of a sender that sends every event alone would cost more than their events.
const TOGETHER: Micros = Micros(1_000);

/// A framed stream that is being read.
///
/// It waits for the bytes of one packet and no more: what a sender sends at once is given at once.
pub struct FramedReader<R> {
    name: PathBuf,
    bytes: R,
    sensor: SensorSize,
    decoder: FramedDecoder,
    /// Bytes read and not yet decoded are `buffer[taken..filled]`.
    buffer: Box<[u8]>,
    taken: usize,
    filled: usize,
    is_at_end: bool,
    /// Offset in the stream of the next byte to decode.
    at: u64,
    events: u64,
}

impl<R: Read> FramedReader<R> {
    /// Reads the header of a stream, which messages call `name`.
    ///
    /// # Errors
    /// If it cannot be read, is none, or states a sensor larger than any.
    pub fn open(name: impl Into<PathBuf>, mut bytes: R) -> Result<Self, IoError> {
        let name = name.into();
        let damage =
            |(byte, reason): (u64, Cow<'static, str>)| IoError::damaged(&name, byte, reason);
        let mut header = [0; HEADER];
        let there = fill(&mut bytes, &mut header).map_err(|e| IoError::file(&name, "read", e))?;
        if there < HEADER {
            let reason = format!("the stream ends {there} bytes into its header");
            return Err(damage((there as u64, reason.into())));
        }
        let sensor = believed(&name, sensor_of(&header).map_err(damage)?)?;
        Ok(Self {
            name,
            bytes,
            sensor,
            // A live stream may lose bytes: the decoder goes on at the next packet.
            decoder: FramedDecoder::lenient().together(TOGETHER),
            buffer: vec![0; BUFFER].into_boxed_slice(),
            taken: 0,
            filled: 0,
            is_at_end: false,
            at: HEADER as u64,
            events: 0,
        })
    }

    /// The sensor.
    pub fn sensor(&self) -> SensorSize {
        self.sensor
    }

    /// Count of places at which bytes were skipped because they are no packet.
    pub fn malformed(&self) -> u64 {
        self.decoder.malformed()
    }

    /// Waits for a packet and appends its events, and those of packets that came with it and are of
    /// the same millisecond; of a long packet some ten thousand. Whether there were any: none come
    /// behind the end of the stream.
    ///
    /// # Errors
    /// If the stream cannot be read, or ends inside a packet. The events before that have been
    /// appended.
    pub fn next(&mut self, columns: &mut Columns) -> Result<bool, IoError> {
        let before = columns.len();
        loop {
            // What is in the buffer first: reading would wait for the other side.
            let bytes = &self.buffer[self.taken..self.filled];
            let had = columns.len();
            let took = self.decoder.decode(bytes, self.is_at_end, columns);
            self.events += (columns.len() - had) as u64;
            let took = took.map_err(|DecodeFault { at, reason }| {
                IoError::damaged(&self.name, self.at + at as u64, reason).behind(self.events)
            })?;
            self.taken += took;
            self.at += took as u64;
            let given = columns.len() - before;
            // Not in the middle of a packet: its events belong together.
            if given >= ENOUGH || given > 0 && self.decoder.is_between() {
                return Ok(true);
            }
            if self.is_at_end {
                return Ok(given > 0);
            }
            self.fill()?;
        }
    }

    /// Waits for further bytes, or for the end.
    fn fill(&mut self) -> Result<(), IoError> {
        // What is left is less than a packet's head or event, so that little is copied.
        self.buffer.copy_within(self.taken..self.filled, 0);
        self.filled -= self.taken;
        self.taken = 0;
        loop {
            match self.bytes.read(&mut self.buffer[self.filled..]) {
                Ok(got) => {
                    self.is_at_end = got == 0;
                    self.filled += got;
                    return Ok(());
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(IoError::file(&self.name, "read", error)),
            }
        }
    }
}
