//! Counts of events per cell, from the front end's thread to the painter's.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use evpose_core::{EventStream, Micros, SensorSize};

use super::{Shared, lock};

/// Upper bound of the cells along the longer side: more are not visible on a screen.
const MAX_CELLS: u16 = 640;

/// Input of the events that a page shows.
#[derive(Clone)]
pub struct PageEvents {
    shared: Arc<Shared>,
}

impl PageEvents {
    pub(super) fn new(shared: Arc<Shared>) -> Self {
        Self { shared }
    }

    /// Counts events; those of a sensor of another size are ignored. Without watchers this does
    /// nothing.
    pub fn push(&self, events: &EventStream) {
        if self.shared.watchers.load(Ordering::Relaxed) > 0 {
            lock(&self.shared.event_counts).count(events);
        }
    }
}

/// Division of a sensor into square cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cells {
    pub(super) width: u16,
    pub(super) height: u16,
    /// Side of a cell in pixels.
    pub(super) side_px: u16,
}

impl Cells {
    pub(super) fn for_sensor(sensor: SensorSize) -> Self {
        let side_px = sensor.width.max(sensor.height).div_ceil(MAX_CELLS).max(1);
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
pub(super) struct EventCounts {
    sensor: SensorSize,
    /// Offset of the counts of a column in a row, and of a row in all.
    column: Vec<u32>,
    row: Vec<u32>,
    /// OFF and ON of every cell, row by row.
    counts: Vec<u8>,
    newest: Option<Micros>,
}

impl EventCounts {
    pub(super) fn new(sensor: SensorSize) -> Self {
        let cells = Cells::for_sensor(sensor);
        // Divisions are made once for each column and row, and not for each event.
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
            // A burst must not turn a bright cell dark.
            *count = count.saturating_add(1);
        }
        self.newest = events.t().last().copied().or(self.newest);
    }

    /// Swaps the counts with `empty` ones. Returns the time of the newest event so far.
    pub(super) fn swap(&mut self, empty: &mut Vec<u8>) -> Option<Micros> {
        std::mem::swap(&mut self.counts, empty);
        self.newest
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Polarity};

    use super::*;

    #[test]
    fn cells_cover_every_sensor() {
        let cells = |width, height| Cells::for_sensor(SensorSize { width, height });
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
        let mut event_counts = EventCounts::new(sensor);
        let corner = [at(5, 1279, 719, Polarity::On), at(6, 1278, 718, Polarity::On)];
        event_counts.count(&EventStream::from_events(sensor, corner).unwrap());
        let many = (0..300).map(|k| at(7 + k, 2, 0, Polarity::Off));
        event_counts.count(&EventStream::from_events(sensor, many).unwrap());
        let mut counts = vec![0; 2 * 640 * 360];
        assert_eq!(event_counts.swap(&mut counts), Some(Micros(306)));
        assert_eq!(counts.pop(), Some(2), "ON of the last cell");
        assert_eq!(counts[2], u8::MAX, "OFF of the second cell");
        assert_eq!(counts.iter().filter(|&&count| count > 0).count(), 1);
    }

    #[test]
    fn events_of_another_sensor_are_left_out() {
        let event = Event { t: Micros(1), x: 90, y: 3, polarity: Polarity::On };
        let other = SensorSize { width: 100, height: 10 };
        let mut event_counts = EventCounts::new(SensorSize { width: 10, height: 10 });
        event_counts.count(&EventStream::from_events(other, [event]).unwrap());
        let mut counts = vec![0; 200];
        assert_eq!(event_counts.swap(&mut counts), None);
        assert!(counts.iter().all(|&count| count == 0));
    }
}
