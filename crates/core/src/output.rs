//! Output files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file written under a temporary name beside its target and renamed on [`AtomicFile::commit`].
///
/// Dropped without a commit, it removes what it wrote: a reader never sees half a file.
#[derive(Debug)]
pub struct AtomicFile {
    writer: Option<BufWriter<File>>,
    temporary: PathBuf,
    target: PathBuf,
}

impl AtomicFile {
    /// Starts writing `target`, creating its directory if needed.
    ///
    /// # Errors
    /// If the directory or the temporary file cannot be created.
    pub fn create(target: impl Into<PathBuf>) -> io::Result<Self> {
        let target = target.into();
        if let Some(parent) = target.parent() {
            fs::create_dir_all(parent)?;
        }
        let mut name = target.file_name().unwrap_or_default().to_os_string();
        name.push(format!(".{}.tmp", std::process::id()));
        let temporary = target.with_file_name(name);
        let writer = Some(BufWriter::with_capacity(1 << 18, File::create(&temporary)?));
        Ok(Self { writer, temporary, target })
    }

    /// Flushes to disk and gives the file its name.
    ///
    /// # Errors
    /// If the disk is full or the rename fails; the target is then untouched.
    pub fn commit(mut self) -> io::Result<()> {
        let writer = self.writer.take().ok_or_else(|| io::Error::other("already committed"))?;
        let file = writer.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.sync_all()?;
        fs::rename(&self.temporary, &self.target)
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.as_mut().ok_or_else(|| io::Error::other("already committed"))?.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.as_mut().map_or(Ok(()), Write::flush)
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        drop(self.writer.take());
        // Gone already after a commit; otherwise nothing more can be done about a failure here.
        let _ = fs::remove_file(&self.temporary);
    }
}

/// Writes `bytes` to `target` through a temporary name.
///
/// # Errors
/// As [`AtomicFile`].
pub fn atomic_write(target: impl AsRef<Path>, bytes: &[u8]) -> io::Result<()> {
    let mut file = AtomicFile::create(target.as_ref())?;
    file.write_all(bytes)?;
    file.commit()
}
