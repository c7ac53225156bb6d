//! A file, or bytes in memory that stand for one.

use std::fs::File;
use std::io::{self, Cursor, Read, Seek};
use std::path::{Path, PathBuf};

use crate::IoError;

/// A reader with random access.
pub trait ReadSeek: Read + Seek + Send {}

impl<R: Read + Seek + Send> ReadSeek for R {}

/// The bytes of a recording, in a file or in memory.
pub struct Input {
    /// Name of the file, for messages, and for files that lie beside it.
    pub path: PathBuf,
    /// Length in bytes.
    pub length: u64,
    /// The bytes.
    pub bytes: Box<dyn ReadSeek>,
}

impl Input {
    /// Opens a file.
    ///
    /// # Errors
    /// If it is not there, or is no regular file.
    pub fn file(path: impl AsRef<Path>) -> Result<Self, IoError> {
        let path = path.as_ref();
        let open = || {
            let file = File::open(path)?;
            let metadata = file.metadata()?;
            // A folder opens without a fault, too.
            if !metadata.is_file() {
                return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file"));
            }
            Ok((file, metadata.len()))
        };
        let (file, length) = open().map_err(|e| IoError::file(path, "open", e))?;
        Ok(Self { path: path.to_owned(), length, bytes: Box::new(file) })
    }

    /// Takes bytes as if they were a file of this name.
    pub fn memory(name: impl Into<PathBuf>, bytes: Vec<u8>) -> Self {
        let length = bytes.len() as u64;
        Self { path: name.into(), length, bytes: Box::new(Cursor::new(bytes)) }
    }

    /// Reads the first `max` bytes, or all of a shorter file, and rewinds.
    ///
    /// # Errors
    /// If they cannot be read.
    pub fn head(&mut self, max: usize) -> Result<Vec<u8>, IoError> {
        let mut head = Vec::new();
        let mut read = || {
            self.bytes.rewind()?;
            (&mut self.bytes).take(max as u64).read_to_end(&mut head)?;
            self.bytes.rewind()
        };
        read().map_err(|e| IoError::file(&self.path, "read", e))?;
        Ok(head)
    }
}
