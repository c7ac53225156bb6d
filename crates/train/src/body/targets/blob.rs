//! Blobs of likelihood around a cell.

use evpose_pose::body::{BodyLabel, Keypoint};
use glam::Vec2;

/// Sizes of blobs, and the share of the image that a body fills less of.
const SIZES: [(usize, f32); 2] = [(3, 0.16), (5, 0.3)];
/// The size for all that fill more.
const LARGEST: usize = 7;
/// How many times `e` a blob falls by at its border.
const STEEPNESS: f64 = 3.0;
const RADII: std::ops::RangeInclusive<usize> = radius(SIZES[0].0)..=radius(LARGEST + 2);

/// Blobs on maps of one size.
///
/// # Model
/// At a distance `d <= r` from its cell, a blob is `exp(-3 d / r)`, further away it is 0. Where
/// several add up to more than 1, they are 1. The published ones lack column and row `r` beyond the
/// cell, not before it.
#[derive(Debug, Clone)]
pub(super) struct Blobs {
    side: usize,
    parity: bool,
    /// By radius, a quarter of the blob, `[row][column]` from its middle.
    quarters: Vec<Vec<f32>>,
}

impl Blobs {
    pub(super) fn new(side: usize, parity: bool) -> Self {
        let value = |r: usize, x: usize, y: usize| {
            let [x, y, r] = [x, y, r].map(|i| i as f64);
            let d = (x * x + y * y).sqrt();
            if d <= r { (-STEEPNESS * d / r).exp() as f32 } else { 0.0 }
        };
        // A blob is symmetric: a quarter has all of its values.
        let quarter = |r: usize| {
            let cell = |i: usize| value(r, i % (r + 1), i / (r + 1));
            (0..(r + 1) * (r + 1)).map(cell).collect()
        };
        Self { side, parity, quarters: RADII.map(quarter).collect() }
    }

    /// Adds a blob to a map.
    ///
    /// # Panics
    /// If the map is of another size, the cell outside of it, or there is no such size.
    pub(super) fn add(&self, map: &mut [f32], [x, y]: [usize; 2], size: usize) {
        assert_eq!(map.len(), self.side * self.side, "a map of another size");
        let r = radius(size);
        let quarter = &self.quarters[r - RADII.start()];
        let beyond = r + usize::from(!self.parity);
        let around = |at: usize| at.saturating_sub(r)..(at + beyond).min(self.side);
        for row in around(y) {
            let values = &quarter[row.abs_diff(y) * (r + 1)..][..r + 1];
            for column in around(x) {
                let value = &mut map[row * self.side + column];
                *value = (*value + values[column.abs_diff(x)]).min(1.0);
            }
        }
    }
}

/// How large blobs are for a person: the more of the image its joints span, the larger.
pub(super) fn size(label: &BodyLabel) -> usize {
    let labelled = || label.keypoints.iter().filter(|keypoint| keypoint.is_labelled());
    let bound = |start: Vec2, of: fn(Vec2, Vec2) -> Vec2| {
        labelled().fold(start, |bound, &Keypoint { position, .. }| of(bound, position))
    };
    let span = bound(Vec2::NEG_INFINITY, Vec2::max) - bound(Vec2::INFINITY, Vec2::min);
    // Without joints both bounds are infinite, and nobody would be the largest person.
    let area = if labelled().next().is_some() { span.element_product() } else { 0.0 };
    SIZES.into_iter().find(|(_, above)| area < *above).map_or(LARGEST, |(size, _)| size)
}

/// How far a blob reaches, in cells.
const fn radius(size: usize) -> usize {
    (size + 6) / 2
}
