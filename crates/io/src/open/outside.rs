//! Events outside the sensor, and the doubt that many of them raise.

use std::path::Path;

use evpose_core::SensorSize;

use crate::{Columns, IoError};

/// Events outside the sensor up to which it is not in doubt.
const FEW: usize = 10;
/// Events from which on their places show whether the sensor is another one.
const MANY: usize = 10_000;

/// Counts of events on a sensor and outside.
#[derive(Debug, Clone, Default)]
pub struct OutsideCount {
    events: usize,
    outside: usize,
    /// The largest column and row; the last value stands for coordinates that no sensor has.
    largest: (u16, u16),
}

impl OutsideCount {
    /// Counts the events from `begin` on.
    pub fn add(&mut self, columns: &Columns, begin: usize, sensor: SensorSize) {
        self.events += columns.len() - begin;
        for (&x, &y) in columns.x[begin..].iter().zip(&columns.y[begin..]) {
            if !sensor.contains(x, y) {
                self.outside += 1;
                self.largest = (self.largest.0.max(x), self.largest.1.max(y));
            }
        }
    }

    /// Events outside.
    pub fn outside(&self) -> usize {
        self.outside
    }

    /// Refuses a recording of which more than a tenth of the events are outside; of the first few, before
    /// its end, many may be.
    ///
    /// # Errors
    /// As it says, of the recording `path`.
    pub fn check(&self, path: &Path, sensor: SensorSize, is_at_end: bool) -> Result<(), IoError> {
        let Self { events, outside, largest: (x, y) } = *self;
        let is_elsewhere = outside > FEW && outside * 10 > events;
        if !is_elsewhere || (events < MANY && !is_at_end) {
            return Ok(());
        }
        let is_turned = x < sensor.height && y < sensor.width;
        Err(IoError::Outside { path: path.to_owned(), sensor, outside, events, is_turned })
    }
}
