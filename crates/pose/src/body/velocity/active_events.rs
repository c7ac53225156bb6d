//! Time stamp of the last event of each pixel, of either polarity.

use evpose_core::{EventStream, Micros, SensorSize};

/// Time of a pixel without events: earlier than every time stamp, and subtracting it cannot
/// overflow.
pub(super) const NEVER: i64 = i64::MIN / 4;
/// Time stamps are clamped between this and its negative: a hundred thousand years.
const MAX_US: i64 = i64::MAX / 4;

#[derive(Debug, Clone)]
pub(super) struct ActiveSurface {
    sensor: SensorSize,
    /// `[height][width]`, microseconds; [`NEVER`] where nothing fired.
    last_us: Vec<i64>,
    newest_us: i64,
}

impl ActiveSurface {
    pub(super) fn new(sensor: SensorSize) -> Self {
        Self { sensor, last_us: vec![NEVER; sensor.pixels()], newest_us: NEVER }
    }

    pub(super) fn sensor(&self) -> SensorSize {
        self.sensor
    }

    /// Time stamp of the last event, microseconds; [`NEVER`] without one.
    pub(super) fn newest_us(&self) -> i64 {
        self.newest_us
    }

    /// Whether events are earlier than those before: another stream begins.
    pub(super) fn is_before(&self, events: &EventStream) -> bool {
        events.t().first().is_some_and(|&first| clamped_us(first) < self.newest_us)
    }

    pub(super) fn push(&mut self, events: &EventStream) {
        assert_eq!(events.sensor(), self.sensor, "events from a sensor of another size");
        let width = usize::from(self.sensor.width);
        for ((&t, &x), &y) in events.t().iter().zip(events.x()).zip(events.y()) {
            self.last_us[usize::from(y) * width + usize::from(x)] = clamped_us(t);
        }
        if let Some(&last) = events.t().last() {
            self.newest_us = clamped_us(last);
        }
    }

    pub(super) fn reset(&mut self) {
        self.last_us.fill(NEVER);
        self.newest_us = NEVER;
    }

    /// Times of the pixels of a row, microseconds.
    pub(super) fn row(&self, y: usize) -> &[i64] {
        let width = usize::from(self.sensor.width);
        &self.last_us[y * width..][..width]
    }
}

fn clamped_us(t: Micros) -> i64 {
    t.0.clamp(-MAX_US + 1, MAX_US)
}
