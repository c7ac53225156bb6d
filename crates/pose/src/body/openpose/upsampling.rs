//! Bicubic upsampling of maps to the resolution of the network's input.

/// Slope of the cubic, as in OpenCV and PyTorch.
const SLOPE: f32 = -0.75;

/// An upsampled map, row by row.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FineMap {
    pub(super) values: Vec<f32>,
    pub(super) rows: usize,
    pub(super) columns: usize,
}

impl FineMap {
    /// The value at a column and a row within the map.
    pub(super) fn at(&self, x: usize, y: usize) -> f32 {
        self.values[y * self.columns + x]
    }
}

/// A map of `rows` by `columns`, `factor` times as large along either side. A pixel is a square, its
/// value that of its middle; the map goes on as it ends.
pub(super) fn upsample(map: &[f32], [rows, columns]: [usize; 2], factor: usize) -> FineMap {
    let across = InterpolationWeights::new(columns, factor);
    let down = InterpolationWeights::new(rows, factor);
    // Weights are separable: along rows first, then along columns.
    let mut wide = Vec::with_capacity(rows * columns * factor);
    for row in map.chunks_exact(columns) {
        let value = |(at, weights): (&[usize; 4], &[f32; 4])| -> f32 {
            at.iter().zip(weights).map(|(x, weight)| weight * row[*x]).sum()
        };
        wide.extend(across.iter().map(value));
    }
    let columns = columns * factor;
    let mut values = Vec::with_capacity(rows * factor * columns);
    for (at, weights) in down.iter() {
        let lines = at.map(|y| &wide[y * columns..][..columns]);
        values.extend((0..columns).map(|x| -> f32 {
            lines.iter().zip(weights).map(|(line, weight)| weight * line[x]).sum()
        }));
    }
    FineMap { values, rows: rows * factor, columns }
}

/// The four pixels that each pixel of an upsampled line is made of, and their weights.
struct InterpolationWeights(Vec<([usize; 4], [f32; 4])>);

impl InterpolationWeights {
    fn new(length: usize, factor: usize) -> Self {
        let tap = |fine: usize| {
            // Middles of pixels correspond, not corners,
            // as where corners are not aligned in PyTorch.
            let at = (fine as f32 + 0.5) / factor as f32 - 0.5;
            let before = at.floor();
            let inside = |k: isize| (before as isize + k).clamp(0, length as isize - 1) as usize;
            ([-1, 0, 1, 2].map(inside), cubic(at - before))
        };
        Self((0..length * factor).map(tap).collect())
    }

    fn iter(&self) -> impl Iterator<Item = (&[usize; 4], &[f32; 4])> {
        self.0.iter().map(|(at, weights)| (at, weights))
    }
}

/// Weights of four pixels at `rest` behind the second.
fn cubic(rest: f32) -> [f32; 4] {
    let near = |d: f32| ((SLOPE + 2.0) * d - (SLOPE + 3.0)) * d * d + 1.0;
    let far = |d: f32| ((d - 5.0) * d + 8.0) * d * SLOPE - 4.0 * SLOPE;
    [far(1.0 + rest), near(rest), near(1.0 - rest), far(2.0 - rest)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_stays_and_a_ramp_is_followed_inside() {
        let fine = upsample(&[3.0; 30], [5, 6], 4);
        assert_eq!([fine.rows, fine.columns], [20, 24]);
        assert!(fine.values.iter().all(|value| (value - 3.0).abs() < 1e-5));
        let ramp: Vec<f32> = (0..30).map(|k| (k % 6) as f32).collect();
        let fine = upsample(&ramp, [5, 6], 4);
        for x in 8..16 {
            let want = (x as f32 + 0.5) / 4.0 - 0.5;
            assert!((fine.at(x, 9) - want).abs() < 0.08, "{x}: {}, not {want}", fine.at(x, 9));
        }
    }
}
