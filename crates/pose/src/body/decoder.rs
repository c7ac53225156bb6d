//! Decoding of a network's maps into the joints of a body.

use glam::Vec2;

use super::{BodyJoint, BodyMaps};

/// The published threshold of [`BodyDecoder::new`].
pub const DEFAULT_THRESHOLD: f32 = 0.1;
/// Published addend of distances, in cells: see [`BodyDecoder::softened_by`].
pub const DEFAULT_SOFTENING: f64 = 1.8;

/// Decodes maps of one size into joints.
///
/// # Model
/// The body's middle is where the map of centres, weighted by `1 / (d + 1.8)` with the distance `d`
/// from the middle of the map in cells, is largest. From there, regressions say roughly where
/// each joint is, and the joint is where its heatmap, weighted in the same way about that place, is
/// largest. Of equal values the first counts, row by row. The offset of that cell says where in it.
///
/// # Source
/// The decoding of the published MoveEnet. That rounds regressions as `trunc(x + 0.5)`: towards
/// zero, not down, so that -0.7 becomes 0 and -1.7 becomes -1, and what is above or to the left of
/// the body's middle is looked for up to a cell too near to it. [`Self::as_published`] does the
/// same; else regressions are taken as they are.
#[derive(Debug, Clone)]
pub struct BodyDecoder {
    rows: usize,
    columns: usize,
    threshold: f32,
    softening: f64,
    center_weight: Vec<f32>,
    cuts_regressions: bool,
}

impl BodyDecoder {
    /// A decoder of maps of `rows` by `columns`; 48 by 48 as published. Values of heatmaps below
    /// `threshold` count as 0, and a joint whose score is below it is not detected.
    pub fn new([rows, columns]: [usize; 2], threshold: f32) -> Self {
        let decoder = Self {
            rows,
            columns,
            threshold,
            softening: DEFAULT_SOFTENING,
            center_weight: Vec::new(),
            cuts_regressions: false,
        };
        decoder.softened_by(DEFAULT_SOFTENING)
    }

    /// The same with weights `1 / (d + cells)`: the more, the less regressions count beside
    /// heatmaps, and the middle of the map beside the map of centres.
    #[must_use]
    pub fn softened_by(self, cells: f64) -> Self {
        let Self { rows, columns, .. } = self;
        let middle = [columns, rows].map(|side| side as f64 / 2.0);
        let weight = |cell: usize| 1.0 / (distance(cell % columns, cell / columns, middle) + cells);
        // The published weights are in single precision, which decides between equals.
        let center_weight = (0..rows * columns).map(|cell| weight(cell) as f32).collect();
        Self { softening: cells, center_weight, ..self }
    }

    /// The same with the published rounding, for comparisons.
    #[must_use]
    pub fn as_published(self) -> Self {
        Self { cuts_regressions: true, ..self }
    }

    /// The joints of a body. Maps are `[channels][rows][columns]`.
    ///
    /// # Panics
    /// If maps are of another size, or of other numbers of joints.
    pub fn decode(&self, maps: &BodyMaps<&[f32]>) -> Vec<BodyJoint> {
        let cells = self.rows * self.columns;
        let joints = maps.heatmaps.len() / cells;
        assert_eq!(maps.heatmaps.len(), joints * cells, "whole heatmaps");
        self.assert_sizes(maps.centers, maps.regs, maps.offsets, joints);
        let center = self.center_cell(maps.centers);
        let joint = |(joint, heatmap): (usize, &[f32])| {
            let rough = self.rough(maps.regs, joint, center);
            let cut = |value: f32| if value < self.threshold { 0.0 } else { value };
            // As MoveNet: scores count the less, the further they are from the rough position.
            let cell = first_maximum((0..cells).map(|cell| {
                let (x, y) = (cell % self.columns, cell / self.columns);
                f64::from(cut(heatmap[cell])) / (distance(x, y, rough) + self.softening)
            }));
            let score = cut(heatmap[cell]);
            let position = || self.position(maps.offsets, joint, cell);
            BodyJoint { position: (score >= self.threshold).then(position), score }
        };
        maps.heatmaps.chunks(cells).enumerate().map(joint).collect()
    }

    fn assert_sizes(&self, centers: &[f32], regs: &[f32], offsets: &[f32], joints: usize) {
        let cells = self.rows * self.columns;
        assert_eq!(centers.len(), cells, "one map of centres");
        assert_eq!(regs.len(), 2 * joints * cells, "two regressions for each joint");
        assert_eq!(offsets.len(), 2 * joints * cells, "two offsets for each joint");
    }

    /// The cell of the body's middle, counted row by row.
    ///
    /// # Panics
    /// If the map is of another size.
    pub fn center_cell(&self, centers: &[f32]) -> usize {
        assert_eq!(centers.len(), self.center_weight.len(), "one map of centres");
        let weighted =
            centers.iter().zip(&self.center_weight).map(|(value, weight)| value * weight);
        first_maximum(weighted.map(f64::from))
    }

    /// Column and row where a joint should be, as seen from the body's middle; maybe outside.
    fn rough(&self, regs: &[f32], joint: usize, center: usize) -> [f64; 2] {
        let from = [center % self.columns, center / self.columns];
        let [x, y] = self.pair(regs, joint, center);
        let place = |value: f32, from: usize| {
            let value = if self.cuts_regressions { (value + 0.5).trunc() } else { value };
            f64::from(value) + from as f64
        };
        [place(x, from[0]), place(y, from[1])]
    }

    /// Position of the joint of a cell, relative to the image.
    fn position(&self, offsets: &[f32], joint: usize, cell: usize) -> Vec2 {
        let [x, y] = self.pair(offsets, joint, cell);
        let relative = |at: usize, offset: f32, side: usize| {
            ((at as f64 + f64::from(offset)) / side as f64) as f32
        };
        Vec2::new(
            relative(cell % self.columns, x, self.columns),
            relative(cell / self.columns, y, self.rows),
        )
    }

    /// The two channels of a joint at a cell.
    fn pair(&self, maps: &[f32], joint: usize, cell: usize) -> [f32; 2] {
        let cells = self.rows * self.columns;
        [maps[2 * joint * cells + cell], maps[(2 * joint + 1) * cells + cell]]
    }
}

/// Euclidean distance of a cell from a position, in cells.
fn distance(x: usize, y: usize, from: [f64; 2]) -> f64 {
    let [x, y] = [x as f64 - from[0], y as f64 - from[1]];
    // Not `hypot`, whose last bit may differ from the published arithmetic's and decide between equals.
    (x * x + y * y).sqrt()
}

/// Index of the largest value, the first of equals; 0 without values.
fn first_maximum(values: impl Iterator<Item = f64>) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (index, value) in values.enumerate() {
        // NaN is not greater than anything, so that it never wins.
        if value > best.1 {
            best = (index, value);
        }
    }
    best.0
}

#[cfg(test)]
mod tests;
