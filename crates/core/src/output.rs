//! Atomic output files: complete or absent.

use std::fs::{self, File};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Ending of temporary names.
const TEMPORARY: &str = ".tmp";

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
        let (temporary, file) = create_temporary(&target)?;
        let writer = Some(BufWriter::with_capacity(1 << 18, file));
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
        #[cfg(debug_assertions)]
        abort::at_counted_write();
        fs::rename(&self.temporary, &self.target)
    }
}

/// Kills of the process in tests, which no build for users has.
#[cfg(debug_assertions)]
mod abort {
    use std::sync::LazyLock;
    use std::sync::atomic::{AtomicU64, Ordering};

    /// The write, counted from 1, before whose rename the process aborts.
    const VARIABLE: &str = "EVPOSE_ABORT_AT_WRITE";

    static AT: LazyLock<Option<u64>> = LazyLock::new(|| std::env::var(VARIABLE).ok()?.parse().ok());
    static WRITES: AtomicU64 = AtomicU64::new(0);

    pub(super) fn at_counted_write() {
        // As a kill between two writes: nothing is flushed or removed.
        if *AT == Some(1 + WRITES.fetch_add(1, Ordering::Relaxed)) {
            std::process::abort();
        }
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

/// For formats whose header stores offsets of later parts.
impl Seek for AtomicFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.writer.as_mut().ok_or_else(|| io::Error::other("already committed"))?.seek(to)
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        drop(self.writer.take());
        // Gone already after a commit; otherwise nothing more can be done about a failure here.
        let _ = fs::remove_file(&self.temporary);
    }
}

/// Creates a file beside `target` under a name not in use: containers that share a directory all
/// have process id 1, and files of killed processes may have any.
fn create_temporary(target: &Path) -> io::Result<(PathBuf, File)> {
    let mut attempt = 0_u32;
    loop {
        let mut name = target.file_name().unwrap_or_default().to_os_string();
        name.push(format!(".{}-{attempt}{TEMPORARY}", std::process::id()));
        let temporary = target.with_file_name(name);
        match File::create_new(&temporary) {
            Ok(file) => return Ok((temporary, file)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => attempt += 1,
            Err(error) => return Err(error),
        }
    }
}

/// The target's name of a temporary file of [`AtomicFile`]; none for other names. Identifies the
/// files that a killed process leaves behind.
pub fn temporary_target(name: &str) -> Option<&str> {
    let (target, tag) = name.strip_suffix(TEMPORARY)?.rsplit_once('.')?;
    let (process, attempt) = tag.split_once('-')?;
    let number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    (number(process) && number(attempt) && !target.is_empty()).then_some(target)
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn two_writers_of_one_target_do_not_share_a_temporary_file() {
        let directory = tempfile::tempdir().unwrap();
        let target = directory.path().join("0007.evc");
        let mut writers = [(); 2].map(|()| AtomicFile::create(&target).unwrap());
        for (writer, text) in writers.iter_mut().zip(["first", "second"]) {
            writer.write_all(text.as_bytes()).unwrap();
        }
        let [first, second] = writers;
        second.commit().unwrap();
        assert_eq!(fs::read_to_string(&target).unwrap(), "second");
        first.commit().unwrap();
        assert_eq!(fs::read_to_string(&target).unwrap(), "first");
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1, "no temporary file stays");
    }

    #[test]
    fn a_file_appears_whole_when_it_is_committed_and_not_before() {
        let directory = tempfile::tempdir().unwrap();
        let target = directory.path().join("new/0007.evc");
        let entries = || fs::read_dir(target.parent().unwrap()).unwrap().count();
        let mut file = AtomicFile::create(&target).unwrap();
        file.write_all(b"size of what follows").unwrap();
        file.seek(SeekFrom::Start(0)).unwrap();
        file.write_all(b"four").unwrap();
        file.flush().unwrap();
        assert_eq!(fs::read(&file.temporary).unwrap(), b"four of what follows");
        assert!(!target.exists() && entries() == 1);
        file.commit().unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"four of what follows");
        drop(AtomicFile::create(&target).unwrap());
        assert_eq!(entries(), 1, "given up, it leaves what was there");
        atomic_write(&target, b"other").unwrap();
        assert_eq!((fs::read(&target).unwrap(), entries()), (b"other".to_vec(), 1));
    }

    #[test]
    fn a_file_that_cannot_be_created_is_an_error() {
        let directory = tempfile::tempdir().unwrap();
        // With the temporary ending it is longer than any file system takes.
        assert!(AtomicFile::create(directory.path().join("x".repeat(255))).is_err());
        let file = directory.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(AtomicFile::create(file.join("below")).is_err());
    }

    #[test]
    fn a_temporary_name_contains_its_target_and_other_names_do_not() {
        let directory = tempfile::tempdir().unwrap();
        let writer = AtomicFile::create(directory.path().join("a.b.evc")).unwrap();
        let name = writer.temporary.file_name().unwrap().to_str().unwrap();
        assert_eq!(temporary_target(name), Some("a.b.evc"));
        for name in ["a.b.evc", "notes.tmp", "notes.1.tmp", ".1-0.tmp", "x.1-a.tmp", "x.-.tmp"] {
            assert_eq!(temporary_target(name), None, "{name}");
        }
    }
}
