//! Reads at an offset that any number of threads may make at once.

use std::fs::File;
use std::io;
use std::path::Path;

/// An open file without a cursor.
#[derive(Debug)]
pub(crate) struct PositionalFile {
    #[cfg(unix)]
    file: File,
    // Elsewhere the cursor is the file's, so one thread reads at a time.
    #[cfg(not(unix))]
    file: std::sync::Mutex<File>,
}

impl PositionalFile {
    pub(crate) fn open(path: &Path) -> io::Result<(Self, u64)> {
        let file = File::open(path)?;
        let metadata = file.metadata()?;
        if !metadata.is_file() {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file"));
        }
        let length = metadata.len();
        #[cfg(not(unix))]
        let file = std::sync::Mutex::new(file);
        Ok((Self { file }, length))
    }

    #[cfg(unix)]
    pub(crate) fn read_exact_at(&self, bytes: &mut [u8], offset: u64) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, bytes, offset)
    }

    #[cfg(not(unix))]
    pub(crate) fn read_exact_at(&self, bytes: &mut [u8], offset: u64) -> io::Result<()> {
        use std::io::{Read, Seek, SeekFrom};
        let mut file = self.file.lock().map_err(|_| io::Error::other("a reader panicked"))?;
        file.seek(SeekFrom::Start(offset))?;
        file.read_exact(bytes)
    }
}
