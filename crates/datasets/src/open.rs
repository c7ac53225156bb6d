//! Opening of MAT-files and CDF files, with errors that carry the path.

use std::path::Path;

use evpose_containers::cdf::CdfFile;
use evpose_containers::mat::MatFile;

use crate::DatasetError;

/// Reads and parses a MAT-file.
///
/// # Errors
/// If it cannot be read, or is no MAT-file of version 5 to 7.2.
pub(crate) fn open_mat(path: &Path) -> Result<MatFile, DatasetError> {
    MatFile::parse(&read(path)?).map_err(DatasetError::mat(path))
}

/// Reads and parses a CDF file.
///
/// # Errors
/// If it cannot be read, or is no CDF file of version 3.
pub(crate) fn open_cdf(path: &Path) -> Result<CdfFile, DatasetError> {
    CdfFile::parse(read(path)?).map_err(DatasetError::cdf(path))
}

fn read(path: &Path) -> Result<Vec<u8>, DatasetError> {
    std::fs::read(path).map_err(DatasetError::io(path, "read it"))
}
