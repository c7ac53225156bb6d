//! How the published program pairs predictions with the labels of its real recordings.
//!
//! Its joints come one row per millisecond; the converter drops the first 14 and the last before it
//! indexes them, and gives no reason. Labels carry their time in the same numbering, every second
//! one is used, and a point with `x + y > 320` is one that nobody labelled. Our own recordings
//! carry times and say which points are labelled, so every default here is "off".
//!
//! # Source
//! EventHands' evaluation program.

use evpose_core::Micros;
use glam::Vec2;
use serde::{Deserialize, Serialize};

/// Rows and labels of published recordings that are evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RecordingConventions {
    /// Rows of predictions that come before time 0.
    pub first_rows_dropped: usize,
    /// Rows of predictions left out at the end.
    pub last_rows_dropped: usize,
    /// Predictions before this time are not evaluated.
    pub evaluated_from: Micros,
    /// One in so many rows of labels is used, from the first on.
    pub label_stride: usize,
    /// A label with `x + y` above this, in pixels, is none.
    pub unlabelled_above_px: Option<f32>,
}

impl RecordingConventions {
    /// As in the published program.
    pub fn published() -> Self {
        Self {
            first_rows_dropped: 14,
            last_rows_dropped: 1,
            evaluated_from: Micros(100_000),
            label_stride: 2,
            unlabelled_above_px: Some(320.0),
        }
    }

    /// Index, among `rows` predictions, one per millisecond, of the one for the label of time `t`.
    pub fn prediction_row(&self, t: Micros, rows: usize) -> Option<usize> {
        let millisecond = Micros::MILLISECOND.0;
        if t < self.evaluated_from || t.0 % millisecond != 0 {
            return None;
        }
        let row = usize::try_from(t.0 / millisecond).ok()?.checked_add(self.first_rows_dropped)?;
        (row < rows.saturating_sub(self.last_rows_dropped)).then_some(row)
    }

    /// Whether row `row` of the labels is used.
    pub fn uses_label_row(&self, row: usize) -> bool {
        row.is_multiple_of(self.label_stride.max(1))
    }

    /// The label at `point_px`, unless the point stands for "not labelled".
    pub fn label(&self, point_px: Vec2) -> Option<Vec2> {
        let unlabelled =
            self.unlabelled_above_px.is_some_and(|limit| point_px.x + point_px.y > limit);
        (!unlabelled).then_some(point_px)
    }
}

impl Default for RecordingConventions {
    fn default() -> Self {
        Self {
            first_rows_dropped: 0,
            last_rows_dropped: 0,
            evaluated_from: Micros(0),
            label_stride: 1,
            unlabelled_above_px: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_rows_are_shifted_and_cut_at_both_ends() {
        let published = RecordingConventions::published();
        let row = |ms: i64| published.prediction_row(Micros(ms * 1_000), 1_000);
        assert_eq!([row(99), row(100), row(984), row(985)], [None, Some(114), Some(998), None]);
        assert_eq!([0, 1, 2, 3].map(|i| published.uses_label_row(i)), [true, false, true, false]);
        assert_eq!(published.label(Vec2::new(200.0, 121.0)), None);
        assert!(published.label(Vec2::new(200.0, 120.0)).is_some());
    }

    #[test]
    fn by_default_every_row_and_label_counts() {
        let plain = RecordingConventions::default();
        assert_eq!(plain.prediction_row(Micros(0), 1), Some(0));
        assert_eq!(plain.prediction_row(Micros(-1_000), 1), None);
        assert_eq!(plain.prediction_row(Micros(1_500), 9), None);
        assert!((0..9).all(|row| plain.uses_label_row(row)));
        assert!(plain.label(Vec2::new(900.0, 900.0)).is_some());
    }
}
