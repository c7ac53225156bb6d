//! NASA's Common Data Format, version 3: the numbers of its variables.
//!
//! * [`CdfFile`]: a file in memory, its variables by name.
//! * [`CdfArray`]: the numbers of a variable.
//! * [`CdfError`]: which byte of the file is wrong.
//!
//! What is read: numbers of all kinds and machines but VAX, by rows or by columns, of variables of both
//! kinds, files and variables compressed by gzip. Attributes are passed over.
//!
//! # Source
//! NASA Goddard Space Flight Center: *CDF Internal Format Description*, version 3.

mod compression;
mod error;
mod file;
mod kind;
mod record;
mod values;

pub use error::CdfError;
pub use file::CdfFile;

/// The numbers of a variable.
#[derive(Debug, Clone, PartialEq)]
pub struct CdfArray {
    /// How many records there are.
    pub records: usize,
    /// Sizes of each record.
    pub sizes: Vec<usize>,
    /// The numbers, record by record, the last dimension running first.
    pub values: Vec<f64>,
}

#[cfg(test)]
mod tests;
