//! The smallest sensor that holds the events of a file that does not state it.

use std::path::Path;

use evpose_core::SensorSize;

use crate::{Columns, IoError};

/// Events that do not set the size where all others are within half of it, and how many others.
const FEW: u64 = 10;
const MANY: u64 = 1_000;
/// Pixels of the largest sensor that is believed: 4096 x 4096, an order of magnitude above cameras.
const MAX_PIXELS: u64 = 1 << 24;

/// Counts of events by their column and by their row.
#[derive(Debug, Default)]
pub(super) struct Extent {
    x: Vec<u64>,
    y: Vec<u64>,
}

impl Extent {
    pub(super) fn of(columns: &Columns) -> Self {
        let mut extent = Self::default();
        extent.add(columns);
        extent
    }

    pub(super) fn add(&mut self, columns: &Columns) {
        for (counts, values) in [(&mut self.x, &columns.x), (&mut self.y, &columns.y)] {
            counts.resize(usize::from(u16::MAX) + 1, 0);
            values.iter().for_each(|value| counts[usize::from(*value)] += 1);
        }
    }

    /// The size, of at least one pixel.
    pub(super) fn size(&self) -> SensorSize {
        SensorSize { width: length(&self.x), height: length(&self.y) }
    }
}

/// Pixels that hold all but a few values that are far from the others.
fn length(counts: &[u64]) -> u16 {
    // The last value stands for coordinates that no sensor has.
    let counts = &counts[..counts.len().min(usize::from(u16::MAX))];
    let last = |counts: &[u64]| counts.iter().rposition(|n| *n > 0).map_or(1, |at| at + 1);
    let whole = last(counts);
    let mut left = FEW;
    let inner = counts[..whole.min(counts.len())].iter().rposition(|n| {
        left = left.saturating_sub(*n);
        left == 0
    });
    let inner = inner.map_or(whole, |at| at + 1);
    let is_far = 2 * inner < whole && counts.iter().sum::<u64>() > MANY;
    // Those of the few that are near the others count again.
    let near = last(&counts[..counts.len().min(2 * inner)]);
    if is_far { near as u16 } else { whole as u16 }
}

/// A size that is no larger than sensors are.
pub(crate) fn believed(path: &Path, sensor: SensorSize) -> Result<SensorSize, IoError> {
    match u64::from(sensor.width) * u64::from(sensor.height) <= MAX_PIXELS {
        true => Ok(sensor),
        false => Err(IoError::SensorTooLarge { path: path.to_owned(), sensor }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn size(x: impl IntoIterator<Item = u16>) -> u16 {
        let mut columns = Columns::new();
        columns.x.extend(x);
        columns.y = vec![0; columns.x.len()];
        Extent::of(&columns).size().width
    }

    #[test]
    fn a_few_events_far_from_the_others_do_not_set_the_size() {
        assert_eq!(size((0..1000).map(|k| k % 346)), 346);
        assert_eq!(size((0..1000).map(|k| k % 346).chain([60_000, 1_300])), 346);
        assert_eq!(size((0..1000).map(|k| k % 346).chain([500; 11])), 501);
        assert_eq!((size([3, 9]), size((0..900).map(|k| k % 346).chain([1_300]))), (10, 1_301));
        assert_eq!((size([]), size([u16::MAX])), (1, 1));
    }

    #[test]
    fn no_sensor_has_a_billion_pixels() {
        let path = Path::new("events.txt");
        let of = |width, height| believed(path, SensorSize { width, height });
        assert!(of(4096, 4096).is_ok() && of(65_535, 200).is_ok());
        assert!(of(65_535, 65_535).is_err());
    }
}
