//! From packet to packet through a file, in memory that is kept.

use std::borrow::Cow;
use std::io::{Seek, SeekFrom};

use super::compression::{Compression, Inflater, Scratch, TOO_LONG};
use super::flat::{Broken, is_whole};
use super::header::{self, FileHeader};
use super::table::{self, Entry};
use crate::fill::fill;
use crate::{Input, IoError};

/// Bytes before the body of a packet: its stream and its size.
pub(super) const HEAD: u64 = 8;

/// A file, and where in it the next packet is.
pub(super) struct Walk {
    input: Input,
    pub(super) header: FileHeader,
    /// Offset of the next packet.
    pub(super) at: u64,
    /// End of the packets: the data table, or the end of the file.
    end: u64,
    /// The head of the packet behind a body is read with it.
    ahead: Option<(u64, [u8; HEAD as usize])>,
    /// Offset of the next byte to read.
    read_to: u64,
    body: Scratch,
    inflater: Inflater,
}

/// Head of a packet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Head {
    pub(super) at: u64,
    pub(super) stream: i32,
    pub(super) size: u64,
}

/// A packet's FlatBuffer behind its size, and what is wrong with it: it may end early then.
pub(super) struct Body<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) fault: Option<IoError>,
}

impl Walk {
    pub(super) fn new(mut input: Input) -> Result<Self, IoError> {
        let mut header = header::read(&mut input)?;
        // A table before the end of the header is a place that only a broken file states.
        header.table = header.table.filter(|&table| table >= header.end);
        Ok(Self {
            at: header.end,
            end: header.table.unwrap_or(u64::MAX).min(input.length),
            read_to: header.end,
            input,
            header,
            ahead: None,
            body: Scratch::default(),
            inflater: Inflater::new(),
        })
    }

    /// The head of the next packet, or none behind the last.
    pub(super) fn head(&mut self) -> Result<Option<Head>, IoError> {
        let at = self.at;
        let left = self.end.saturating_sub(at);
        if left == 0 {
            return match self.header.table.filter(|&table| table > self.input.length) {
                Some(table) => Err(self.damage(
                    at,
                    format!("the file is cut: its data table should begin at byte {table}"),
                )),
                None => Ok(None),
            };
        }
        // Mostly read already, with the body of the packet before: one read a packet instead of
        // two.
        let bytes = match self.ahead {
            Some((place, bytes)) if place == at => bytes,
            _ => {
                self.read(at, left.min(HEAD))?;
                let Some(bytes) = self.body.filled().first_chunk() else {
                    return Err(self.damage(at, format!("{left} bytes are too few for a packet")));
                };
                *bytes
            }
        };
        self.ahead = Some((at, bytes));
        let [a, b, c, d, size @ ..] = bytes;
        let size = u64::try_from(i32::from_le_bytes(size));
        let size = size.map_err(|_| self.damage(at + 4, "a packet has a size below zero"))?;
        Ok(Some(Head { at, stream: i32::from_le_bytes([a, b, c, d]), size }))
    }

    /// Body of a packet.
    pub(super) fn body(&mut self, head: &Head) -> Result<Body<'_>, IoError> {
        let at = head.at + HEAD;
        let left = self.end.saturating_sub(at);
        // A cut body is read as far as it goes: its first events may be whole.
        let there = head.size.min(left);
        self.read(at, (there + HEAD).min(left))?;
        let there = (there as usize).min(self.body.filled().len());
        let (bytes, next) = self.body.filled().split_at(there);
        self.ahead = next.first_chunk().map(|bytes| (at + head.size, *bytes));
        // A cut explains what does not unpack.
        let mut reason =
            ((there as u64) < head.size).then(|| (head.at, cut(there as u64, head.size)));
        let bytes = match self.header.compression {
            Compression::None => bytes,
            compression => {
                if let Err(fault) = self.inflater.inflate(compression, bytes) {
                    reason = reason.or(Some((at, fault)));
                }
                self.inflater.out.filled()
            }
        };
        // A FlatBuffer states its own length.
        if reason.is_none() && !is_whole(bytes) {
            reason = Some((at, "a FlatBuffer is cut".into()));
        }
        let path = &self.input.path;
        let fault = reason.map(|(byte, reason)| IoError::damaged(path, byte, reason));
        Ok(Body { bytes, fault })
    }

    /// Goes on behind a packet without looking into it.
    pub(super) fn skip(&mut self, head: &Head) -> Result<(), IoError> {
        let there = self.end.saturating_sub(head.at + HEAD);
        if there < head.size {
            return Err(self.damage(head.at, cut(there, head.size)));
        }
        self.pass(head);
        Ok(())
    }

    /// Goes on behind a packet that was read.
    pub(super) fn pass(&mut self, head: &Head) {
        self.at = head.at + HEAD + head.size;
    }

    /// The entries of the data table, if there is one that can be read.
    pub(super) fn table(&mut self) -> Result<Option<Vec<Entry>>, IoError> {
        let Some(at) = self.header.table.filter(|&table| table < self.input.length) else {
            return Ok(None);
        };
        let length = self.input.length - at;
        // The table only spares walking over the packets, so a damaged one is as good as none.
        match self.read(at, length) {
            Ok(()) => {}
            Err(damage) if damage.is_damage() => return Ok(None),
            Err(other) => return Err(other),
        }
        let bytes = self.body.filled();
        if self.inflater.inflate(self.header.compression, bytes).is_err() {
            return Ok(None);
        }
        Ok(table::decode(self.inflater.out.filled()).ok())
    }

    /// The error for a fault in the FlatBuffer of a packet.
    pub(super) fn broken(&self, head: &Head, Broken { at, reason }: Broken) -> IoError {
        let inside = if self.header.compression == Compression::None { at as u64 } else { 0 };
        self.damage(head.at + HEAD + inside, reason)
    }

    fn damage(&self, byte: u64, reason: impl Into<Cow<'static, str>>) -> IoError {
        IoError::damaged(&self.input.path, byte, reason)
    }

    /// Replaces the body by the `most` bytes from `at` on, or as many as there are.
    fn read(&mut self, at: u64, most: u64) -> Result<(), IoError> {
        let failed = |e| IoError::file(&self.input.path, "read", e);
        // A seek would discard the buffer of the input.
        if self.read_to != at {
            self.input.bytes.seek(SeekFrom::Start(at)).map_err(failed)?;
        }
        self.read_to = u64::MAX;
        self.body.clear();
        let length = usize::try_from(most).unwrap_or(usize::MAX);
        let Some((_, room)) = self.body.room(length) else {
            return Err(IoError::damaged(&self.input.path, at, TOO_LONG));
        };
        let filled = fill(&mut self.input.bytes, room).map_err(failed)?;
        self.body.add(filled);
        self.read_to = at + filled as u64;
        Ok(())
    }
}

fn cut(there: u64, size: u64) -> Cow<'static, str> {
    format!("the packets end {there} bytes into a body of {size}").into()
}
