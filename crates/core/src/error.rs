//! Errors of events and planes that break a rule of this crate.

use crate::{Micros, SensorSize};

/// An event or a plane that breaks a rule of this crate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CoreError {
    /// An event lies outside its sensor.
    #[error("event {index} at ({x}, {y}) lies outside the {sensor} sensor")]
    OutsideSensor {
        /// Position in the stream.
        index: usize,
        /// Column.
        x: u16,
        /// Row.
        y: u16,
        /// Size of the sensor.
        sensor: SensorSize,
    },
    /// An event is earlier than the one before it.
    #[error("event {index} at {t} is earlier than the one before it, at {previous}")]
    OutOfOrder {
        /// Position in the stream.
        index: usize,
        /// Time stamp of the event.
        t: Micros,
        /// The time before.
        previous: Micros,
    },
    /// Columns of events of different lengths.
    #[error("columns of {lengths:?} times, columns, rows and polarities")]
    ColumnLengths {
        /// Lengths of times, columns, rows and polarities.
        lengths: [usize; 4],
    },
    /// The data of a plane does not match its size.
    #[error("{width}x{height} needs {} values, got {got}", width * height)]
    PlaneSize {
        /// Width in pixels.
        width: usize,
        /// Height in pixels.
        height: usize,
        /// Values given.
        got: usize,
    },
}
