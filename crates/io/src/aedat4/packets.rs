//! Everything a file holds, packet by packet.

use std::path::Path;

use super::compression::Compression;
use super::header::Stream;
use super::packet::{Aedat4Packet, Content};
use super::walk::{Body, Walk};
use crate::{Input, IoError};

/// The packets of a file in their order, of all streams.
///
/// Damage ends them: it is the last item, and every packet before it was whole.
pub struct Packets {
    walk: Walk,
    /// Events so far.
    events: u64,
    is_over: bool,
}

impl Packets {
    /// Opens a file.
    ///
    /// # Errors
    /// If it cannot be read, or is no AEDAT 4.0 file.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, IoError> {
        Self::from_input(Input::file(path)?)
    }

    /// As [`Packets::open`], from a file that is open already, or from memory.
    ///
    /// # Errors
    /// As [`Packets::open`].
    pub fn from_input(input: Input) -> Result<Self, IoError> {
        Ok(Self { walk: Walk::new(input)?, events: 0, is_over: false })
    }

    /// The streams that the header names.
    pub fn streams(&self) -> &[Stream] {
        &self.walk.header.streams
    }

    /// How the packets are compressed.
    pub fn compression(&self) -> Compression {
        self.walk.header.compression
    }

    fn read(&mut self) -> Result<Option<Aedat4Packet>, IoError> {
        let Some(head) = self.walk.head()? else {
            return Ok(None);
        };
        let Body { bytes, fault } = self.walk.body(&head)?;
        let content = match fault {
            None => Content::decode(bytes),
            Some(fault) => return Err(fault),
        };
        let content = content.map_err(|broken| self.walk.broken(&head, broken))?;
        // Passed only once its content is decoded: a fault leaves the walk at the packet.
        self.walk.pass(&head);
        if let Content::Events(columns) = &content {
            self.events += columns.len() as u64;
        }
        Ok(Some(Aedat4Packet { stream: head.stream, content }))
    }
}

impl Iterator for Packets {
    type Item = Result<Aedat4Packet, IoError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.is_over {
            return None;
        }
        let packet = self.read().map_err(|error| error.behind(self.events)).transpose();
        // Behind a fault nobody knows where the next packet begins.
        self.is_over = !matches!(packet, Some(Ok(_)));
        packet
    }
}
