//! NASA's Common Data Format, version 3: numeric variables, read from the bytes of a file.
//!
//! * [`CdfFile`]: a file in memory, its variables by name.
//! * [`CdfArray`]: the values of a variable.
//! * [`CdfError`]: the byte of the file that is wrong.
//!
//! Numeric types of all machines but VAX are read, in row-major or column-major order, of
//! r-variables and z-variables, from files and variables that are plain or compressed by gzip.
//! Attributes are skipped.
//!
//! ```
//! use evpose_containers::cdf::CdfFile;
//!
//! # let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/cdf/records.cdf");
//! # let bytes = std::fs::read(path).expect("a file of the tests");
//! let file = CdfFile::parse(bytes)?;
//! let pose = file.values("Pose")?;
//! assert_eq!((pose.records, pose.sizes), (7, vec![64]));
//! assert_eq!(pose.values[..2], [0.25, 1.25]);
//! # Ok::<(), evpose_containers::cdf::CdfError>(())
//! ```
//!
//! # Source
//! NASA Goddard Space Flight Center: *CDF Internal Format Description*, version 3.

mod compression;
mod error;
mod file;
mod kind;
mod record;
#[cfg(test)]
mod tests;
mod values;

pub use error::CdfError;
pub use file::CdfFile;

/// The values of a variable, as `f64`.
#[derive(Debug, Clone, PartialEq)]
pub struct CdfArray {
    /// Count of records.
    pub records: usize,
    /// Dimensions of each record.
    pub sizes: Vec<usize>,
    /// Values, record by record, in row-major order.
    pub values: Vec<f64>,
}
