//! Events from a socket or a pipe, as they come.
//!
//! dv-processing's `NetworkWriter` sends what a file holds behind its version line, without an end
//! and without a data table. A whole file, as `cat` gives it, is read, too.
//!
//! # Source
//! Bytes that the `NetworkWriter` of dv-processing 2.0.4 sent; see `tests/golden/aedat4-network`.

use std::borrow::Cow;
use std::io::{self, BufReader, Read};
use std::path::PathBuf;

use evpose_core::SensorSize;

use super::compression::{Inflater, MAX_BYTES, TOO_LONG};
use super::flat::{identifier, is_whole};
use super::header::{self, FileHeader, IDENTIFIER, StreamKind};
use super::walk::HEAD;
use super::{MAGIC, events};
use crate::fill::fill;
use crate::open::believed;
use crate::{Columns, IoError};

/// Bytes by which [`is_stream`] detects a stream of AEDAT 4.0.
pub const SNIFF_BYTES: usize = 12;
/// Bytes of a header, at most; those of recordings with many streams have some ten thousand.
const MAX_HEADER: u32 = 1 << 24;
/// Bytes that are asked for at once: a packet of some thousand events.
const BUFFER: usize = 1 << 16;

/// Whether a stream begins with these bytes, of which there should be [`SNIFF_BYTES`].
pub fn is_stream(head: &[u8]) -> bool {
    head.starts_with(&MAGIC[..SNIFF_BYTES]) || head.get(8..SNIFF_BYTES) == Some(IDENTIFIER)
}

/// A stream of AEDAT 4.0 that is being read.
///
/// It waits for the bytes of one packet and no more. Packets of other streams are passed over.
pub struct Aedat4Stream<R> {
    name: PathBuf,
    bytes: BufReader<R>,
    header: FileHeader,
    /// The stream of events that is read.
    chosen: i32,
    sensor: Option<SensorSize>,
    /// Offset of the next byte in the stream.
    at: u64,
    events: u64,
    malformed: u64,
    body: Vec<u8>,
    inflater: Inflater,
}

impl<R: Read> Aedat4Stream<R> {
    /// Reads the header of a stream, which messages call `name`, and chooses a camera, counted from
    /// 0.
    ///
    /// # Errors
    /// If it cannot be read, is none, does not name the camera, or states a sensor larger than any.
    pub fn open(name: impl Into<PathBuf>, bytes: R, camera: u8) -> Result<Self, IoError> {
        let name = name.into();
        let mut bytes = BufReader::with_capacity(BUFFER, bytes);
        let mut at = 0;
        let mut read = |out: &mut [u8]| {
            let there = fill(&mut bytes, out).map_err(|e| IoError::file(&name, "read", e))?;
            at += there as u64;
            match there == out.len() {
                true => Ok(()),
                false => Err(IoError::damaged(&name, at, "the stream ends in its header")),
            }
        };
        let mut head = vec![0; 4];
        read(&mut head)?;
        let mut start = 0;
        // A file has a first line before its header, a connection has none.
        if head == MAGIC[..4] {
            let mut line = *MAGIC;
            read(&mut line[4..])?;
            if line != *MAGIC {
                return Err(IoError::damaged(&name, 0, "the first line is not `#!AER-DAT4.0`"));
            }
            read(&mut head)?;
            start = MAGIC.len() as u64;
        }
        let size = head.first_chunk().map_or(0, |size| u32::from_le_bytes(*size));
        // A connection that is of another protocol would name any size.
        if size > MAX_HEADER {
            return Err(IoError::damaged(
                &name,
                start,
                format!("a header of {size} bytes is none"),
            ));
        }
        head.resize(4 + size as usize, 0);
        read(&mut head[4..])?;
        let header = header::parse(&name, start, &head)?;
        let cameras = || header.streams.iter().filter(|stream| stream.kind == StreamKind::Events);
        let Some(chosen) = cameras().nth(camera.into()) else {
            let reason =
                format!("no camera {camera}: the stream has {} of them", cameras().count());
            return Err(IoError::Stream { path: name, reason });
        };
        let (chosen, sensor) = (chosen.id, chosen.size);
        sensor.map(|sensor| believed(&name, sensor)).transpose()?;
        Ok(Self {
            name,
            bytes,
            chosen,
            sensor,
            at: header.end,
            header,
            events: 0,
            malformed: 0,
            body: Vec::new(),
            inflater: Inflater::new(),
        })
    }

    /// The sensor, where the header states it.
    pub fn sensor(&self) -> Option<SensorSize> {
        self.sensor
    }

    /// Packets of the camera that were passed over because they made no sense.
    pub fn malformed(&self) -> u64 {
        self.malformed
    }

    /// Waits for a packet of events and appends them. Whether there was one: none comes behind the
    /// end of the stream.
    ///
    /// # Errors
    /// If the stream cannot be read, ends inside a packet, or loses its frame: a size makes no
    /// sense.
    pub fn next(&mut self, columns: &mut Columns) -> Result<bool, IoError> {
        let before = columns.len();
        while columns.len() == before {
            // Behind the packets of a file is its data table.
            if self.header.table.is_some_and(|table| self.at >= table) {
                return Ok(false);
            }
            let Some((stream, size)) = self.head()? else { return Ok(false) };
            // Packets of other streams are read away: a socket cannot skip.
            let there = if stream == self.chosen {
                self.body.clear();
                (&mut self.bytes).take(size).read_to_end(&mut self.body).map(|there| there as u64)
            } else {
                io::copy(&mut (&mut self.bytes).take(size), &mut io::sink())
            };
            let there = there.map_err(|e| IoError::file(&self.name, "read", e))?;
            if there < size {
                let reason = format!("the stream ends {there} bytes into a packet of {size}");
                return Err(self.damage(self.at, reason));
            }
            self.at += HEAD + size;
            // A packet that cannot be read is passed over: a live view goes on.
            if stream == self.chosen && !self.decode(columns) {
                columns.truncate(before);
                self.malformed += 1;
            }
            self.events += (columns.len() - before) as u64;
        }
        Ok(true)
    }

    /// Stream and size of the next packet; none at the end.
    fn head(&mut self) -> Result<Option<(i32, u64)>, IoError> {
        let mut head = [0; HEAD as usize];
        match fill(&mut self.bytes, &mut head) {
            Ok(0) => return Ok(None),
            // A cut head is damage; only between two packets may a stream end.
            Ok(there) if there < head.len() => {
                let reason = format!("the stream ends {there} bytes into the head of a packet");
                return Err(self.damage(self.at, reason));
            }
            Ok(_) => {}
            Err(error) => return Err(IoError::file(&self.name, "read", error)),
        }
        let [a, b, c, d, size @ ..] = head;
        match usize::try_from(i32::from_le_bytes(size)) {
            Err(_) => Err(self.damage(self.at + 4, "a packet has a size below zero")),
            // Before anything is allocated: a wrong size would ask for gigabytes.
            Ok(size) if size > MAX_BYTES => Err(self.damage(self.at + 4, TOO_LONG)),
            Ok(size) => Ok(Some((i32::from_le_bytes([a, b, c, d]), size as u64))),
        }
    }

    /// Appends the events of the body; whether it made sense.
    fn decode(&mut self, columns: &mut Columns) -> bool {
        if self.inflater.inflate(self.header.compression, &self.body).is_err() {
            return false;
        }
        let bytes = self.inflater.out.filled();
        is_whole(bytes)
            && identifier(bytes)
                .is_ok_and(|letters| StreamKind::from_identifier(letters) == StreamKind::Events)
            && events::decode(bytes, columns).is_ok_and(|missing| missing == 0)
    }

    fn damage(&self, byte: u64, reason: impl Into<Cow<'static, str>>) -> IoError {
        IoError::damaged(&self.name, byte, reason).behind(self.events)
    }
}
