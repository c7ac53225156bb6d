//! What can go wrong with a file, and where in it.

use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};

use evpose_core::SensorSize;

use crate::evc::EvcFault;
use crate::frames::FrameFault;
use crate::meta::MetaFault;
use crate::npz::NpzFault;
use crate::open::FORMATS;

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
    /// A recording breaks its format.
    #[error("{}: byte {byte}: {reason} ({events} events readable before it)", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Offset of the fault.
        byte: u64,
        /// What is wrong there.
        reason: Cow<'static, str>,
        /// Events before it.
        events: u64,
    },
    /// Events that a stream cannot take: it ends later, or its sensor is smaller.
    #[error("{}: {reason}", path.display())]
    Stream {
        /// The file the events are from.
        path: PathBuf,
        /// Why not.
        reason: String,
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
    /// A NumPy archive whose directory, at its end, cannot be read.
    #[error("{}: byte {byte}: {reason} (0 arrays readable before it)", path.display())]
    NotAnArchive {
        /// The file.
        path: PathBuf,
        /// The end of the file, where the directory should be.
        byte: u64,
        /// What is wrong with it.
        reason: String,
    },
    /// A NumPy archive without all the arrays of a recording.
    #[error(
        "{}: no array {} (found: {})", path.display(), missing.join(", "), found.join(", ")
    )]
    MissingArrays {
        /// The file.
        path: PathBuf,
        /// What it lacks.
        missing: Vec<&'static str>,
        /// What it has.
        found: Vec<String>,
    },
    /// An array of a NumPy archive does not hold what it should.
    #[error(
        "{}: array `{array}` at byte {byte}: {fault} ({values} of its values readable before it)",
        path.display()
    )]
    Npz {
        /// The file.
        path: PathBuf,
        /// The array.
        array: String,
        /// Where its data begin in the file.
        byte: u64,
        /// What is wrong with it.
        fault: NpzFault,
        /// Values before the fault.
        values: usize,
    },
    /// Frames that cannot be read, or are not of one sequence.
    #[error("{}: {fault}", path.display())]
    Frames {
        /// The file, or the folder.
        path: PathBuf,
        /// What is wrong with it.
        fault: FrameFault,
    },
    /// A name that ends like none of the formats.
    #[error(
        "{}: the name should end in {}", path.display(),
        FORMATS.iter().filter(|f| f.create.is_some()).flat_map(|f| f.endings).copied().collect::<Vec<_>>().join(", ")
    )]
    UnknownEnding {
        /// The file.
        path: PathBuf,
    },
    /// A file whose content fits no format.
    #[error(
        "{}: byte 0: the content is of no known format ({})",
        path.display(),
        FORMATS.iter().map(|format| format.name).collect::<Vec<_>>().join(", ")
    )]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// A file that this build cannot read.
    #[error(
        "{}: {format} is not read by this build: build it with `--features {feature}`",
        path.display()
    )]
    NeedsFeature {
        /// The file.
        path: PathBuf,
        /// What it is.
        format: &'static str,
        /// The Cargo feature that reads it.
        feature: &'static str,
    },
    /// A line of a table of numbers is no row of it.
    #[error(
        "{}: line {line} at byte {byte}: {reason} ({rows} rows readable before it)", path.display()
    )]
    Row {
        /// The file.
        path: PathBuf,
        /// Which line; the first is 1.
        line: u64,
        /// Where it begins.
        byte: u64,
        /// What is wrong with it.
        reason: String,
        /// Rows before it.
        rows: u64,
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
    /// Whether what comes before the fault is readable, and whole.
    pub fn is_damage(&self) -> bool {
        matches!(self, Self::Damaged { .. })
    }

    /// Where in the file the fault is, if what the file holds is at fault and the fault has a place.
    ///
    /// What a file lacks as a whole (an array, a camera) has none, and neither have files that could
    /// not be read at all or cannot be written.
    pub fn byte(&self) -> Option<u64> {
        match self {
            Self::Evc { byte, .. }
            | Self::Damaged { byte, .. }
            | Self::Meta { byte, .. }
            | Self::Row { byte, .. }
            | Self::NotAnArchive { byte, .. }
            | Self::Npz { byte, .. } => Some(*byte),
            // Recognised by how it begins.
            Self::UnknownFormat { .. } => Some(0),
            _ => None,
        }
    }

    /// The same damage with `events` readable before it.
    pub(crate) fn behind(mut self, count: u64) -> Self {
        if let Self::Damaged { events, .. } = &mut self {
            *events = count;
        }
        self
    }

    pub(crate) fn file(path: &Path, action: &'static str, source: io::Error) -> Self {
        Self::File { path: path.to_owned(), action, source }
    }

    pub(crate) fn frames(path: &Path, fault: FrameFault) -> Self {
        Self::Frames { path: path.to_owned(), fault }
    }

    pub(crate) fn unwritable(path: &Path, reason: impl Into<String>) -> Self {
        Self::Unwritable { path: path.to_owned(), reason: reason.into() }
    }
}
