//! Requests with their stamps: of all pixels, or of one band.

use evpose_core::{Micros, Polarity};

use crate::clock::stamp;
use crate::{Origin, Request};

/// A request with its stamp.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stamped {
    pub(crate) t: Micros,
    /// Row in the upper half and column in the lower one: the order is that of pixels.
    pub(crate) position: u32,
    pub(crate) polarity: Polarity,
    pub(crate) origin: Origin,
}

impl Stamped {
    /// Column of the pixel.
    pub(crate) fn x(&self) -> u16 {
        self.position as u16
    }

    /// Row of the pixel.
    pub(crate) fn y(&self) -> u16 {
        (self.position >> 16) as u16
    }
}

/// Stamped events in the order of their requests, and what is known of that order.
#[derive(Debug)]
pub(crate) struct StampedEvents {
    pub(crate) events: Vec<Stamped>,
    /// The first stamp and the last one; without events the first one is the later one.
    pub(crate) low: i64,
    pub(crate) high: i64,
    pub(crate) is_by_time: bool,
    pub(crate) is_by_pixel: bool,
}

impl StampedEvents {
    pub(crate) fn new() -> Self {
        let (low, high) = (i64::MAX, i64::MIN);
        Self { events: Vec::new(), low, high, is_by_time: true, is_by_pixel: true }
    }

    /// Holds nothing, with room for as much as before.
    pub(crate) fn clear(&mut self) {
        self.stamp(&[], Micros(0), RowDivision::new(1));
    }

    /// Holds the stamped `requests` and nothing else, none before `earliest`.
    pub(crate) fn stamp(&mut self, requests: &[Request], earliest: Micros, rows: RowDivision) {
        let (mut low, mut high) = (i64::MAX, i64::MIN);
        let (mut is_by_time, mut is_by_pixel) = (true, true);
        let (mut last_t, mut last_pixel) = (i64::MIN, 0);
        self.events.clear();
        self.events.extend(requests.iter().map(|request| {
            let t = stamp(request.t_s).max(earliest);
            (low, high) = (low.min(t.0), high.max(t.0));
            is_by_time &= t.0 >= last_t;
            is_by_pixel &= request.pixel >= last_pixel;
            (last_t, last_pixel) = (t.0, request.pixel);
            let (polarity, origin) = (request.polarity, request.origin);
            Stamped { t, position: rows.position(request.pixel), polarity, origin }
        }));
        (self.low, self.high) = (low, high);
        (self.is_by_time, self.is_by_pixel) = (is_by_time, is_by_pixel);
    }
}

/// A division of pixel indices by the width of the sensor.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowDivision {
    width: u64,
    /// `2^40 / width`, rounded up: right for any pixel number of a sensor.
    reciprocal: u64,
}

/// Bits of the fraction of `reciprocal`.
const SHIFT: u32 = 40;

impl RowDivision {
    pub(crate) fn new(width: u16) -> Self {
        let width = u64::from(width).max(1);
        Self { width, reciprocal: (1u64 << SHIFT).div_ceil(width) }
    }

    /// Row of a pixel in the upper half and column in the lower one.
    fn position(self, pixel: u32) -> u32 {
        // A division by the width takes some twenty cycles, once for every event.
        let row = (u64::from(pixel) * self.reciprocal) >> SHIFT;
        let column = u64::from(pixel) - row * self.width;
        (row as u32) << 16 | u32::from(column as u16)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_columns_are_those_of_a_division() {
        for width in [1u16, 2, 3, 240, 346, 1280, 65_535] {
            let rows = RowDivision::new(width);
            let last = u64::from(width) * 65_535 - 1;
            for pixel in (0..=last).step_by(last as usize / 5_000 + 1).chain([last]) {
                let row = (pixel * rows.reciprocal) >> SHIFT;
                assert!(row == pixel / u64::from(width) || pixel >= 1 << 24, "{pixel} / {width}");
            }
        }
    }
}
