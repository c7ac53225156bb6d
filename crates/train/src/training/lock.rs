//! The lock of a run directory: one process trains in it at a time.

use std::fs::{File, TryLockError};
use std::io::{Read as _, Seek as _, Write as _};
use std::path::Path;

use crate::TrainError;

/// Name of the file in the run directory. It holds the process id of who trains there, and is empty otherwise.
const NAME: &str = "run.lock";

/// A lock of the operating system, which ends with the process that has it, however that ends.
#[derive(Debug)]
pub(super) struct RunLock(File);

impl RunLock {
    /// Locks `directory`, which must exist.
    ///
    /// # Errors
    /// [`TrainError::InUse`] if another process trains there, or another run of this one.
    pub(super) fn acquire(directory: &Path) -> Result<Self, TrainError> {
        let path = directory.join(NAME);
        let io = |source| TrainError::Io { path: path.clone(), source };
        let opened =
            File::options().read(true).write(true).create(true).truncate(false).open(&path);
        let mut file = opened.map_err(io)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut process = String::new();
                // Where the lock also forbids reading, the message goes without.
                let _ = file.read_to_string(&mut process);
                return Err(TrainError::InUse { path: directory.to_owned(), process });
            }
            // On file systems without locks, some of them of the network, nobody is kept out.
            Err(TryLockError::Error(_)) => {}
        }
        file.set_len(0).map_err(io)?;
        write!(file, "{}", std::process::id()).map_err(io)?;
        Ok(Self(file))
    }
}

impl Drop for RunLock {
    fn drop(&mut self) {
        // Finished runs are the same bytes whoever trained them. The file stays: removed, it could be locked twice.
        let _ = self.0.rewind().and_then(|()| self.0.set_len(0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_is_locked_once_and_a_dead_process_leaves_it_free() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join(NAME);
        // As a killed process leaves it.
        std::fs::write(&path, "4194305").unwrap();
        let first = RunLock::acquire(directory.path()).unwrap();
        let message = RunLock::acquire(directory.path()).unwrap_err().to_string();
        assert!(message.contains(&format!("process {}", std::process::id())), "{message}");
        drop(first);
        assert_eq!(std::fs::read(&path).unwrap(), b"");
        RunLock::acquire(directory.path()).unwrap();
    }
}
