//! Events counted in cells, between the thread that follows them and the one that draws them.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use evpose_core::{EventStream, Micros, SensorSize};

use super::{Shared, lock};

/// Cells along the longer side, at most: more is not seen on a screen.
const MOST_CELLS: u16 = 640;

/// Gives a page the events that it shows.
#[derive(Clone)]
pub struct PageEvents {
    shared: Arc<Shared>,
}

impl PageEvents {
    pub(super) fn new(shared: Arc<Shared>) -> Self {
        Self { shared }
    }

    /// Shows events; those of another sensor than the page's are left out. As long as nobody watches, they
    /// are not looked at.
    pub fn push(&self, events: &EventStream) {
        if self.shared.watchers.load(Ordering::Relaxed) > 0 {
            lock(&self.shared.plane).count(events);
        }
    }
}

/// How the pixels of a sensor are gathered in square cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cells {
    /// Columns.
    pub(super) width: u16,
    /// Rows.
    pub(super) height: u16,
    /// Pixels along a side of a cell.
    pub(super) side_px: u16,
}

impl Cells {
    pub(super) fn of(sensor: SensorSize) -> Self {
        let side_px = sensor.width.max(sensor.height).div_ceil(MOST_CELLS).max(1);
        Self {
            width: sensor.width.div_ceil(side_px),
            height: sensor.height.div_ceil(side_px),
            side_px,
        }
    }

    pub(super) fn len(self) -> usize {
        usize::from(self.width) * usize::from(self.height)
    }
}

/// Events since the last frame.
pub(super) struct Plane {
    sensor: SensorSize,
    /// Where the counts of a column begin in a row, and those of a row in all.
    column: Vec<u32>,
    row: Vec<u32>,
    /// OFF and ON of every cell, row by row.
    counts: Vec<u8>,
    /// Time of the newest event.
    newest: Option<Micros>,
}

impl Plane {
    pub(super) fn new(sensor: SensorSize) -> Self {
        let cells = Cells::of(sensor);
        let cell = |px: u16| u32::from(px / cells.side_px);
        Self {
            sensor,
            column: (0..sensor.width).map(|x| 2 * cell(x)).collect(),
            row: (0..sensor.height).map(|y| 2 * cell(y) * u32::from(cells.width)).collect(),
            counts: vec![0; 2 * cells.len()],
            newest: None,
        }
    }

    pub(super) fn count(&mut self, events: &EventStream) {
        if events.sensor() != self.sensor {
            return;
        }
        for ((&x, &y), &polarity) in events.x().iter().zip(events.y()).zip(events.polarity()) {
            let cell = self.row[usize::from(y)] + self.column[usize::from(x)];
            let count = &mut self.counts[cell as usize + polarity as usize];
            *count = count.saturating_add(1);
        }
        self.newest = events.t().last().copied().or(self.newest);
    }

    /// Exchanges the counts for `empty` ones, and tells the time of the newest event so far.
    pub(super) fn take(&mut self, empty: &mut Vec<u8>) -> Option<Micros> {
        std::mem::swap(&mut self.counts, empty);
        self.newest
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use evpose_core::{Event, Polarity};

    use super::*;

    #[test]
    fn cells_cover_every_sensor() {
        let cells = |width, height| Cells::of(SensorSize { width, height });
        assert_eq!(cells(346, 260), Cells { width: 346, height: 260, side_px: 1 });
        assert_eq!(cells(640, 480), Cells { width: 640, height: 480, side_px: 1 });
        assert_eq!(cells(641, 480), Cells { width: 321, height: 240, side_px: 2 });
        assert_eq!(cells(1280, 720), Cells { width: 640, height: 360, side_px: 2 });
        assert_eq!(cells(1, u16::MAX), Cells { width: 1, height: 637, side_px: 103 });
        assert_eq!(cells(0, 0).len(), 0);
    }

    #[test]
    fn events_are_counted_in_their_cells() {
        let sensor = SensorSize { width: 1280, height: 720 };
        let at = |t, x, y, polarity| Event { t: Micros(t), x, y, polarity };
        let mut plane = Plane::new(sensor);
        let corner = [at(5, 1279, 719, Polarity::On), at(6, 1278, 718, Polarity::On)];
        plane.count(&EventStream::from_events(sensor, corner).unwrap());
        let many = (0..300).map(|k| at(7 + k, 2, 0, Polarity::Off));
        plane.count(&EventStream::from_events(sensor, many).unwrap());
        let mut counts = vec![0; 2 * 640 * 360];
        assert_eq!(plane.take(&mut counts), Some(Micros(306)));
        assert_eq!(counts.pop(), Some(2), "ON of the last cell");
        assert_eq!(counts[2], u8::MAX, "OFF of the second cell");
        assert_eq!(counts.iter().filter(|&&count| count > 0).count(), 1);
    }

    #[test]
    fn events_of_another_sensor_are_left_out() {
        let event = Event { t: Micros(1), x: 90, y: 3, polarity: Polarity::On };
        let other = SensorSize { width: 100, height: 10 };
        let mut plane = Plane::new(SensorSize { width: 10, height: 10 });
        plane.count(&EventStream::from_events(other, [event]).unwrap());
        let mut counts = vec![0; 200];
        assert_eq!(plane.take(&mut counts), None);
        assert!(counts.iter().all(|&count| count == 0));
    }
}
