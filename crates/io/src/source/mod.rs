//! Recordings in batches: the bytes, the header, and the events behind it.

mod blocks;
mod input;
mod memory;
mod order;
mod ordered;
mod shifted;
mod stated;
mod time_check;
mod unpacked;

use evpose_core::{Micros, SensorSize};
use serde::{Deserialize, Serialize};

pub use blocks::{BlockSource, DecodeFault, DecodeResult, Decoder};
pub use input::{Input, ReadSeek};
pub use memory::MemorySource;
pub(crate) use ordered::OrderedSource;
pub(crate) use shifted::Shifted;
pub use stated::{ColumnNames, TimeUnit};
pub(crate) use unpacked::{CUT, max_unpacked, unpacked};

use crate::{Columns, IoError};

/// Options for files that leave a choice.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct OpenOptions {
    /// The sensor, for files that do not state it.
    pub sensor: Option<SensorSize>,
    /// Camera of a file that holds several, counted from 0. Without it, a file with one camera
    /// is that camera; of a file with several, the first is read and the others are remarked on.
    pub camera: Option<u8>,
    /// Microseconds of a tick, for files that do not state it (YARP: 0.08 or 1).
    pub tick_us: Option<f64>,
    /// Keep what is readable of a damaged file, instead of refusing it.
    pub salvage: bool,
    /// The parts to read where the clock starts again.
    pub restarts: Restarts,
    /// Unit of times, for tables and arrays that do not state it.
    pub time_unit: Option<TimeUnit>,
    /// Names of the columns, for tables and arrays.
    pub columns: ColumnNames,
    /// Whether rows and columns of pixels are exchanged.
    pub swap_xy: bool,
    /// Whether times count from the first event.
    pub zero_time: bool,
    /// Topic of the events, of recordings of ROS that hold several.
    pub topic: Option<String>,
}

/// The parts to read of a recording whose clock starts again within the file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Restarts {
    /// Nothing: it is an error that says where.
    #[default]
    Refuse,
    /// One part, counted from 1.
    Part(usize),
    /// All parts, each from the time on at which the one before it ended.
    Join,
    /// All events by their time stamps, whatever their order; the recording is read into memory.
    Sort,
}

/// The header of a file, before its first event.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Header {
    /// The sensor, where the file states it.
    pub sensor: Option<SensorSize>,
    /// The sensor such files usually come from, where they never state it.
    pub usual_sensor: Option<SensorSize>,
    /// Further facts for descriptions of the file: name and value, such as camera and date.
    pub facts: Vec<(&'static str, String)>,
}

/// A recording that is read from its beginning, or from a time, in batches.
pub trait EventSource: Send {
    /// The header of the file.
    fn header(&self) -> &Header;

    /// Appends the next batch, some thousand events in the order of the file, which of a recording
    /// opened by [`crate::source()`] is that of time; none at the end, and then whenever it is called
    /// again.
    ///
    /// # Errors
    /// If the file cannot be read, or is damaged where reading has come to. Everything before the
    /// damage has been appended then, by this call or by those before.
    fn next(&mut self, columns: &mut Columns) -> Result<(), IoError>;

    /// Hands over the recording as a whole if it lies in memory and none of it has been read: the
    /// source is empty from then on. Readers of whole recordings save a copy by it.
    fn take_all(&mut self) -> Option<Columns> {
        None
    }

    /// Appends all that is left.
    ///
    /// # Errors
    /// As [`Self::next`].
    fn read_rest(&mut self, columns: &mut Columns) -> Result<(), IoError> {
        read_batches(self, columns)
    }

    /// Goes to a place from which reading on gives every event at `t` or later whose predecessors
    /// are all earlier than `t`, and possibly some before it.
    ///
    /// # Errors
    /// If the file cannot be read.
    fn seek(&mut self, t: Micros) -> Result<(), IoError>;

    /// Duration of the content read so far, if the format states more than its events do.
    fn duration(&self) -> Option<Micros> {
        None
    }

    /// Remarks on the content read so far, in whole sentences without a full stop.
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Appends batch by batch what a source has left.
fn read_batches(
    source: &mut (impl EventSource + ?Sized),
    columns: &mut Columns,
) -> Result<(), IoError> {
    let mut before = usize::MAX;
    while columns.len() != before {
        before = columns.len();
        source.next(columns)?;
    }
    Ok(())
}
