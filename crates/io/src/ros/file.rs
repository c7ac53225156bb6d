//! Files of messages, read unit by unit: a chunk of them, or one that stands alone.

use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::fields::{Reason, Serialisation};
use crate::{Input, IoError, ReadSeek};

/// Longest unit that is believed.
const MAX_UNIT: u64 = 1 << 30;

/// A fault of a file.
pub(super) enum Fault {
    Read(io::Error),
    Damage {
        byte: u64,
        reason: Reason,
    },
    /// A file of a known kind without messages of ROS.
    Stranger(Reason),
}

impl Fault {
    pub(super) fn damage(byte: u64, reason: impl Into<Reason>) -> Self {
        Self::Damage { byte, reason: reason.into() }
    }

    /// The same fault, for when it is met again.
    pub(super) fn again(&self) -> Self {
        match self {
            Self::Read(error) => Self::Read(io::Error::new(error.kind(), error.to_string())),
            Self::Damage { byte, reason } => Self::damage(*byte, reason.clone()),
            Self::Stranger(reason) => Self::Stranger(reason.clone()),
        }
    }

    /// The error of a file of a kind.
    pub(super) fn of_file(self, (path, kind): (&Path, &str), events: u64) -> IoError {
        match self {
            Self::Read(error) => IoError::file(path, "read", error),
            Self::Damage { byte, reason } => {
                IoError::damaged(path, byte, format!("{kind}: {reason}")).behind(events)
            }
            Self::Stranger(reason) => {
                IoError::Stream { path: path.to_owned(), reason: reason.into_owned() }
            }
        }
    }
}

/// The place of the next unit, if there is one.
pub(super) type NextUnit = Result<Option<u64>, Fault>;

/// A topic of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Topic {
    pub(super) name: String,
    /// Type of its messages, `package/Name` or `package/msg/Name`.
    pub(super) kind: String,
    pub(super) serialisation: Serialisation,
    /// Identifiers in the file: several publishers may have one topic.
    pub(super) ids: Vec<u32>,
    pub(super) messages: u64,
}

/// Reads units one after the other from the place `at` on. Returns the fault that ends them before the file does.
pub(super) fn to_the_end(mut at: u64, mut read: impl FnMut(u64) -> NextUnit) -> Option<Fault> {
    loop {
        match read(at) {
            Ok(Some(next)) => at = next,
            Ok(None) => return None,
            Err(fault) => return Some(fault),
        }
    }
}

/// Appends a connection of a topic.
pub(super) fn add_topic(topics: &mut Vec<Topic>, topic: Topic) {
    match topics.iter_mut().find(|other| other.name == topic.name && other.kind == topic.kind) {
        Some(other) => {
            other.ids.extend(topic.ids);
            other.messages += topic.messages;
        }
        None => topics.push(topic),
    }
}

/// Takes a message.
pub(super) type MessageVisitor<'a> = dyn FnMut(&[u8]) -> Result<(), Reason> + 'a;

/// A file of messages.
pub(super) trait MessageFile: Send {
    /// The kind of file, for errors.
    fn kind(&self) -> &'static str;

    /// The topics, as its index says; without one, those of what can be read, and the fault that
    /// ends it.
    fn topics(&mut self) -> (Vec<Topic>, Option<Fault>);

    /// Place of the first unit.
    fn begin(&self) -> u64;

    /// Hands over the messages of a unit that are of the topics `ids`; returns the place of the next.
    fn unit(&mut self, at: u64, ids: &[u32], take: &mut MessageVisitor<'_>) -> NextUnit;
}

/// A file of messages, and its name for errors.
pub(super) type NamedFile = (PathBuf, Box<dyn MessageFile>);

/// Bytes that are mostly read one after the other.
pub(super) struct Bytes {
    bytes: BufReader<Box<dyn ReadSeek>>,
    pub(super) length: u64,
    position: u64,
}

impl Bytes {
    pub(super) fn new(input: Input) -> Self {
        Self { bytes: BufReader::new(input.bytes), length: input.length, position: u64::MAX }
    }

    /// Replaces the content of `buffer` by `length` bytes of the record that begins at `record`.
    pub(super) fn read(
        &mut self,
        (record, at): (u64, u64),
        length: u64,
        buffer: &mut Vec<u8>,
    ) -> Result<(), Fault> {
        // Before memory is asked for.
        if length > MAX_UNIT {
            return Err(Fault::damage(record, format!("a record of {length} bytes")));
        }
        if at.checked_add(length).is_none_or(|end| end > self.length) {
            return Err(Fault::damage(record.min(self.length), "the file ends within a record"));
        }
        // A seek would discard what is buffered.
        if self.position != at {
            self.bytes.seek(SeekFrom::Start(at)).map_err(Fault::Read)?;
        }
        buffer.resize(length as usize, 0);
        self.bytes.read_exact(buffer).map_err(Fault::Read)?;
        self.position = at + length;
        Ok(())
    }
}
