//! Writes `.meta` files record by record.

use std::io::Write;
use std::path::{Path, PathBuf};

use evpose_core::AtomicFile;
use evpose_pose::{HandParams, PARAMETERS};

use super::MAGIC;
use super::fault::MAX_VALUES;
use crate::IoError;

/// Writes a `.meta` file, which appears under its name on [`MetaWriter::finish`].
#[derive(Debug)]
pub struct MetaWriter {
    path: PathBuf,
    file: AtomicFile,
    values: usize,
    records: u64,
}

impl MetaWriter {
    /// Starts a file with records of `values` values.
    ///
    /// # Errors
    /// If the file cannot be created or no label has that many values.
    pub fn create(path: impl AsRef<Path>, values: usize) -> Result<Self, IoError> {
        let path = path.as_ref().to_owned();
        let count = i32::try_from(values).ok().filter(|_| (1..=MAX_VALUES).contains(&values));
        let Some(count) = count else {
            let reason = format!("a record has 1 to {MAX_VALUES} values, not {values}");
            return Err(IoError::unwritable(&path, reason));
        };
        let file = AtomicFile::create(&path).map_err(|e| IoError::file(&path, "create", e))?;
        let mut writer = Self { path, file, values, records: 0 };
        writer.write(&count.to_le_bytes())?;
        Ok(writer)
    }

    /// Starts a file of hands, 12 parameters a record.
    ///
    /// # Errors
    /// If the file cannot be created.
    pub fn create_for_hands(path: impl AsRef<Path>) -> Result<Self, IoError> {
        Self::create(path, PARAMETERS)
    }

    /// Appends one record.
    ///
    /// # Errors
    /// If it does not have as many values as the file says, or the disk is full.
    pub fn record(&mut self, values: &[f64]) -> Result<(), IoError> {
        if values.len() != self.values {
            let (got, wanted) = (values.len(), self.values);
            let reason = format!("record {} has {got} values instead of {wanted}", self.records);
            return Err(IoError::unwritable(&self.path, reason));
        }
        for value in values {
            self.write(&value.to_le_bytes())?;
        }
        self.write(&MAGIC)?;
        self.records += 1;
        Ok(())
    }

    /// Appends the pose of a hand.
    ///
    /// # Errors
    /// As [`MetaWriter::record`].
    pub fn hand(&mut self, params: &HandParams) -> Result<(), IoError> {
        self.record(&params.to_f64())
    }

    /// Records written so far.
    pub fn records(&self) -> u64 {
        self.records
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// If the disk is full.
    pub fn finish(self) -> Result<(), IoError> {
        self.file.commit().map_err(|e| IoError::file(&self.path, "finish", e))
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), IoError> {
        self.file.write_all(bytes).map_err(|e| IoError::file(&self.path, "write", e))
    }
}
