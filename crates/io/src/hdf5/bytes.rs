//! The bytes of a file, for two readers: `hdf5-reader` for its structure, ours for its chunks.

use std::io::{self, Read, Seek, SeekFrom};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use hdf5_reader::error::Error;
use hdf5_reader::{Storage, StorageBuffer};

use crate::{Input, ReadSeek};

/// A file of which any part can be read.
pub(super) struct Bytes {
    length: u64,
    reader: Mutex<Box<dyn ReadSeek>>,
    /// Offset of the last read of file structure, the best available position for its damage.
    last: AtomicU64,
}

impl Bytes {
    pub(super) fn new(input: Input) -> Self {
        Self { length: input.length, reader: Mutex::new(input.bytes), last: AtomicU64::new(0) }
    }

    /// Offset of the last read of file structure.
    pub(super) fn last(&self) -> u64 {
        self.last.load(Ordering::Relaxed)
    }

    /// A place of the file: where something should be that is not there any more, its end.
    pub(super) fn within(&self, byte: u64) -> u64 {
        byte.min(self.length)
    }

    /// Replaces what is in `bytes` by `length` bytes from `offset` on, or as many as there are.
    pub(super) fn read(&self, offset: u64, length: u64, bytes: &mut Vec<u8>) -> io::Result<()> {
        bytes.clear();
        if offset >= self.length {
            return Ok(());
        }
        // A reader that panicked left nothing behind that the next one minds.
        let mut reader = self.reader.lock().unwrap_or_else(PoisonError::into_inner);
        reader.seek(SeekFrom::Start(offset))?;
        let length = length.min(self.length - offset);
        bytes.reserve(length as usize);
        (&mut *reader).take(length).read_to_end(bytes)?;
        Ok(())
    }
}

impl Storage for Bytes {
    fn len(&self) -> u64 {
        self.length
    }

    fn read_range(&self, offset: u64, length: usize) -> Result<StorageBuffer, Error> {
        self.last.store(offset.min(self.length), Ordering::Relaxed);
        let available = self.length.saturating_sub(offset);
        let mut bytes = Vec::new();
        // Before memory is taken: lengths are those of an unknown file.
        if length as u64 <= available {
            self.read(offset, length as u64, &mut bytes)?;
        }
        if bytes.len() < length {
            return Err(Error::UnexpectedEof { offset, needed: length as u64, available });
        }
        Ok(StorageBuffer::from_vec(bytes))
    }
}
