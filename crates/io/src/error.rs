//! Errors of files, with the byte of the fault.

use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};

use evpose_core::{Micros, SensorSize};

use crate::evc::EvcFault;
use crate::frames::FrameFault;
use crate::meta::MetaFault;
use crate::npz::NpzFault;

/// A file that cannot be read or written as asked.
///
/// Every variant names the file; a fault of the content also carries the byte offset and
/// how much could be read before it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The operating system refused.
    #[error("{}: cannot {action}", path.display())]
    File {
        /// File that was refused.
        path: PathBuf,
        /// The failed action, an infinitive.
        action: &'static str,
        /// The reason.
        source: io::Error,
    },
    /// An `.evc` file breaks its format.
    #[error(
        "{}: byte {byte}: {fault} (frames 0..{frames}, {events} events readable before it)",
        path.display()
    )]
    Evc {
        /// The recording.
        path: PathBuf,
        /// Offset of the faulty record.
        byte: u64,
        /// The fault.
        fault: EvcFault,
        /// Whole frames before it.
        frames: u64,
        /// Events in those frames.
        events: u64,
    },
    /// A recording breaks its format.
    #[error("{}: byte {byte}: {reason} ({events} events readable before it)", path.display())]
    Damaged {
        /// The recording.
        path: PathBuf,
        /// Offset of the fault.
        byte: u64,
        /// The fault.
        reason: Cow<'static, str>,
        /// Events before it.
        events: u64,
    },
    /// The clock of a recording starts again within the file.
    #[error(
        "{}: the clock goes back at event {event}, from {:.6} s to {:.6} s: read one part with --part 1 or \
         --part 2, all parts one after the other with --join, or all events by their time stamps with \
         --sort",
        path.display(), from.as_seconds(), to.as_seconds()
    )]
    ClockRestart {
        /// The recording.
        path: PathBuf,
        /// The first event of the next part, counted from 0.
        event: u64,
        /// The latest time before.
        from: Micros,
        /// Its time.
        to: Micros,
    },
    /// Time stamps without order.
    #[error(
        "{}: {strays} of the first {events} events have time stamps far from the others: read all by their \
         time stamps with --sort",
        path.display()
    )]
    NoOrder {
        /// The recording.
        path: PathBuf,
        /// Events far from the others.
        strays: u64,
        /// Events read.
        events: u64,
    },
    /// A part beyond the last.
    #[error("{}: there is no part {part}: the clock starts {parts} times", path.display())]
    NoSuchPart {
        /// The recording.
        path: PathBuf,
        /// The part that was asked for.
        part: usize,
        /// Parts that there are.
        parts: usize,
    },
    /// A given size of the sensor that is not the one that the file states.
    #[error("{}: the file states a sensor of {stated}, not of {given}", path.display())]
    OtherSensor {
        /// The recording.
        path: PathBuf,
        /// Size as given.
        given: SensorSize,
        /// Size as the file states it.
        stated: SensorSize,
    },
    /// A size that no sensor has.
    #[error(
        "{}: a sensor of {sensor} is larger than any: give the right size with --sensor, or other columns \
         with --columns",
        path.display()
    )]
    SensorTooLarge {
        /// The recording.
        path: PathBuf,
        /// Size as stated, given, or of the events.
        sensor: SensorSize,
    },
    /// A given size of the sensor that does not hold the events.
    #[error(
        "{}: events lie outside a sensor of {given}: it takes at least {extent} to hold them",
        path.display()
    )]
    SmallerSensor {
        /// The recording.
        path: PathBuf,
        /// Size as given.
        given: SensorSize,
        /// Smallest size that holds every event.
        extent: SensorSize,
    },
    /// More than a tenth of the events are outside the sensor.
    #[error(
        "{}: {outside} of {events} events are outside a sensor of {sensor}: {}",
        path.display(),
        if *is_turned {
            "they fit it when columns and rows are exchanged, with --swap-xy"
        } else {
            "give the right size with --sensor, or other columns with --columns"
        }
    )]
    Outside {
        /// The recording.
        path: PathBuf,
        /// The sensor, as stated or given.
        sensor: SensorSize,
        /// Events outside.
        outside: usize,
        /// Events so far.
        events: usize,
        /// Whether those outside fit the sensor turned by a quarter.
        is_turned: bool,
    },
    /// Events that a stream cannot take: it ends later, or its sensor is smaller.
    #[error("{}: {reason}", path.display())]
    Stream {
        /// The file the events are from.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// A `.meta` file breaks its format.
    #[error("{}: byte {byte}: {fault} ({records} records readable before it)", path.display())]
    Meta {
        /// The `.meta` file.
        path: PathBuf,
        /// Offset of the fault.
        byte: u64,
        /// The fault.
        fault: MetaFault,
        /// Whole records before it.
        records: u64,
    },
    /// A NumPy archive without all the arrays of a recording.
    #[error(
        "{}: no array {} (found: {})", path.display(), missing.join(", "), present.join(", ")
    )]
    MissingArrays {
        /// The archive.
        path: PathBuf,
        /// Names of the missing arrays.
        missing: Vec<&'static str>,
        /// Names of the arrays in the archive.
        present: Vec<String>,
    },
    /// An array of a NumPy archive does not hold what it should.
    #[error(
        "{}: array `{array}` at byte {byte}: {fault} ({values} of its values readable before it)",
        path.display()
    )]
    Npz {
        /// The archive.
        path: PathBuf,
        /// The array.
        array: String,
        /// Offset of its data in the file.
        byte: u64,
        /// The fault.
        fault: NpzFault,
        /// Values before the fault.
        values: usize,
    },
    /// Frames that cannot be read, or are not of one sequence.
    #[error("{}: {fault}", path.display())]
    Frames {
        /// The file, or the folder.
        path: PathBuf,
        /// The fault.
        fault: FrameFault,
    },
    /// A name that ends like none of the formats.
    #[error(
        "{}: the name should end in {known}", path.display()
    )]
    UnknownEnding {
        /// File with the ending.
        path: PathBuf,
        /// Extensions of the formats that can be written.
        known: String,
    },
    /// A file of another kind.
    #[error("{}: byte 0: no recording, it is {what}: {advice}", path.display())]
    NoRecording {
        /// The file.
        path: PathBuf,
        /// The kind of file.
        what: &'static str,
        /// Advice to the user.
        advice: &'static str,
    },
    /// A file whose content fits no format.
    #[error(
        "{}: byte 0: the content is of no known format ({known})", path.display()
    )]
    UnknownFormat {
        /// The label file.
        path: PathBuf,
        /// Names of the formats that were tried.
        known: String,
    },
    /// A file that this build cannot read.
    #[error(
        "{}: {format} is not read by this build: build it with `--features {feature}`",
        path.display()
    )]
    NeedsFeature {
        /// The recording.
        path: PathBuf,
        /// The format of the file.
        format: &'static str,
        /// The Cargo feature that reads it.
        feature: &'static str,
    },
    /// A line of a table that is not a valid row.
    #[error(
        "{}: line {line} at byte {byte}: {reason} ({rows} rows readable before it)", path.display()
    )]
    Row {
        /// The table.
        path: PathBuf,
        /// Line, counted from 1.
        line: u64,
        /// Offset of its beginning.
        byte: u64,
        /// The fault.
        reason: String,
        /// Rows before it.
        rows: u64,
    },
    /// Frames were asked for that the file does not have.
    #[error("{}: frames {start}..{end} of {available}", path.display())]
    NoSuchFrames {
        /// The recording.
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
        /// The recording.
        path: PathBuf,
        /// The sensor.
        sensor: SensorSize,
    },
    /// Something the format cannot hold was to be written.
    #[error("{}: cannot be written: {reason}", path.display())]
    Unwritable {
        /// File that was to be written.
        path: PathBuf,
        /// The content that does not fit.
        reason: String,
    },
}

impl IoError {
    /// Whether the content before the fault is readable, and whole.
    pub fn is_damage(&self) -> bool {
        matches!(self, Self::Damaged { .. })
    }

    /// Offset of the fault, if the content of the file is at fault and the fault has a position.
    ///
    /// A missing array or camera has none, and neither have files that could
    /// not be read at all or cannot be written.
    pub fn byte(&self) -> Option<u64> {
        match self {
            Self::Evc { byte, .. }
            | Self::Damaged { byte, .. }
            | Self::Meta { byte, .. }
            | Self::Row { byte, .. }
            | Self::Npz { byte, .. } => Some(*byte),
            // A format is detected by its first bytes.
            Self::UnknownFormat { .. } | Self::NoRecording { .. } => Some(0),
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

    /// The same fault of a content that begins `skipped` bytes behind the beginning of its file.
    pub(crate) fn behind_bytes(mut self, skipped: u64) -> Self {
        if let Self::Damaged { byte, .. } | Self::Row { byte, .. } = &mut self {
            *byte += skipped;
        }
        self
    }

    /// Damage before the first event; [`Self::behind`] says how many are readable.
    pub(crate) fn damaged(path: &Path, byte: u64, reason: impl Into<Cow<'static, str>>) -> Self {
        Self::Damaged { path: path.to_owned(), byte, reason: reason.into(), events: 0 }
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
