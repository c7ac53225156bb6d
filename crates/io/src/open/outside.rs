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

    /// Whether more than a tenth of the events are outside.
    pub(super) fn is_more_than_a_tenth(&self) -> bool {
        self.outside * 10 > self.events
    }

    /// Refuses a recording of which more than a tenth of the events are outside; of the first few, before
    /// its end, many may be.
    ///
    /// # Errors
    /// As it says, of the recording `path`.
    pub fn check(&self, path: &Path, sensor: SensorSize, is_at_end: bool) -> Result<(), IoError> {
        let Self { events, outside, largest: (x, y) } = *self;
        let is_elsewhere = outside > FEW && self.is_more_than_a_tenth();
        if !is_elsewhere || (events < MANY && !is_at_end) {
            return Ok(());
        }
        let is_turned = x < sensor.height && y < sensor.width;
        Err(IoError::Outside { path: path.to_owned(), sensor, outside, events, is_turned })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{OpenOptions, Windows, info, open_as};

    #[test]
    fn exchanged_axes_are_said_by_every_reader_and_read_when_asked() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("turned.txt");
        let event = |k: i64| format!("{} {} {} {}\n", 100 * k, k % 72, (k / 9) % 96, k % 2);
        let text = "96 72\n".to_owned() + &(0..12_000).map(event).collect::<String>();
        std::fs::write(&path, &text).unwrap();
        let read = |options: &OpenOptions| -> [Result<u64, IoError>; 3] {
            let whole = |path: &Path| Ok(open_as(path, options)?.stream.len() as u64);
            let windows = |path: &Path| {
                let mut windows = Windows::open(path, options)?;
                windows.end()?;
                Ok(windows.outside() as u64)
            };
            [whole(&path), info(&path, options).map(|info| info.events), windows(&path)]
        };
        for error in read(&OpenOptions::default()).map(Result::unwrap_err) {
            assert!(error.to_string().contains("with --swap-xy"), "{error}");
        }
        // A size that events fit as they are is turned with them, another one stays.
        let swapped = OpenOptions { swap_xy: true, ..OpenOptions::default() };
        for (stated, width) in [("96 72", 96), ("72 96", 96)] {
            std::fs::write(&path, text.replace("96 72", stated)).unwrap();
            for (events, want) in read(&swapped).into_iter().zip([12_000, 12_000, 0]) {
                assert_eq!(events.unwrap(), want, "{stated}");
            }
            assert_eq!(info(&path, &swapped).unwrap().sensor.width, width);
        }
        // Neither way.
        std::fs::write(&path, text.replace("96 72", "60 60")).unwrap();
        for error in read(&OpenOptions::default()).map(Result::unwrap_err) {
            assert!(error.to_string().contains("with --sensor"), "{error}");
        }
    }
}
