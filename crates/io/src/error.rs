//! What can go wrong with a file, and where in it.

use std::io;
use std::path::{Path, PathBuf};

use evpose_core::SensorSize;

use crate::evc::EvcFault;
use crate::meta::MetaFault;

/// A file that cannot be read or written as asked.
///
/// Every variant names the file; what is wrong with its contents also carries the byte offset and
/// how much could be read before it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The operating system refused.
    #[error("{}: cannot {action}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What was tried, an infinitive.
        action: &'static str,
        /// Why not.
        source: io::Error,
    },
    /// An `.evc` file breaks its format.
    #[error(
        "{}: byte {byte}: {fault} (frames 0..{frames}, {events} events readable before it)",
        path.display()
    )]
    Evc {
        /// The file.
        path: PathBuf,
        /// Offset of the faulty record.
        byte: u64,
        /// What is wrong there.
        fault: EvcFault,
        /// Whole frames before it.
        frames: u64,
        /// Events in those frames.
        events: u64,
    },
    /// A `.meta` file breaks its format.
    #[error("{}: byte {byte}: {fault} ({records} records readable before it)", path.display())]
    Meta {
        /// The file.
        path: PathBuf,
        /// Offset of the fault.
        byte: u64,
        /// What is wrong there.
        fault: MetaFault,
        /// Whole records before it.
        records: u64,
    },
    /// Frames were asked for that the file does not have.
    #[error("{}: frames {start}..{end} of {available}", path.display())]
    NoSuchFrames {
        /// The file.
        path: PathBuf,
        /// First frame asked for.
        start: u64,
        /// One past the last.
        end: u64,
        /// Frames in the file.
        available: u64,
    },
    /// The format has no room for a sensor of this size.
    #[error("{}: .evc holds sensors of up to 256 rows, this one is {sensor}", path.display())]
    SensorTooTall {
        /// The file.
        path: PathBuf,
        /// The sensor.
        sensor: SensorSize,
    },
    /// Something the format cannot hold was to be written.
    #[error("{}: cannot be written: {reason}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        reason: String,
    },
}

impl IoError {
    pub(crate) fn file(path: &Path, action: &'static str, source: io::Error) -> Self {
        Self::File { path: path.to_owned(), action, source }
    }

    pub(crate) fn unwritable(path: &Path, reason: impl Into<String>) -> Self {
        Self::Unwritable { path: path.to_owned(), reason: reason.into() }
    }
}
