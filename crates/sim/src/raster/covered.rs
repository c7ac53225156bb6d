//! The list of covered pixels, which the shading pass iterates over.

use evpose_core::{LANES, LaneWork, Lanes, in_lanes};

use super::Raster;
use super::triangle::pack_xy;

/// Pixels covered by a face.
#[derive(Debug, Clone, Default)]
pub(crate) struct CoveredPixels {
    /// Packed positions; allocated for the whole image, so that they never grow.
    positions: Vec<i32>,
    triangles: Vec<i32>,
    count: usize,
}

impl CoveredPixels {
    /// Lists the covered pixels of `raster`, row by row.
    pub(crate) fn list(&mut self, raster: &Raster) {
        let capacity = raster.sensor.pixels().next_multiple_of(LANES);
        self.positions.resize(capacity, 0);
        self.triangles.resize(capacity, 0);
        self.count = 0;
        in_lanes(List { raster, covered: self });
        // The last group of eight is read whole.
        let behind = self.count..self.count.next_multiple_of(LANES);
        self.positions[behind.clone()].fill(0);
        self.triangles[behind].fill(0);
    }

    /// Number of covered pixels.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Groups of eight packed positions ([`pack_xy`]) and triangle indices; the last group is
    /// padded with valid ones.
    pub(crate) fn eights(&self) -> impl Iterator<Item = (&[i32; LANES], &[i32; LANES])> {
        let eights = self.count.div_ceil(LANES);
        self.positions.as_chunks().0.iter().zip(self.triangles.as_chunks().0).take(eights)
    }
}

struct List<'a> {
    raster: &'a Raster,
    covered: &'a mut CoveredPixels,
}

impl LaneWork for List<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Raster { visibility, rect, .. } = self.raster;
        let CoveredPixels { positions, triangles: indices, count } = self.covered;
        for y in rect.top..rect.bottom {
            for x in (rect.left..rect.right).step_by(LANES) {
                let Some((inverse_depth, triangles)) = visibility.lanes(x, y) else { return };
                let known = u32::MAX >> (u32::BITS as usize - (rect.right - x).min(LANES));
                let is_seen = l.greater_i(l.load_i(*inverse_depth), l.splat_i(0));
                let mut left = l.mask_bits(is_seen) & known;
                let first = pack_xy(x, y);
                while left != 0 {
                    let k = left.trailing_zeros() as usize % LANES;
                    left &= left - 1;
                    (positions[*count], indices[*count]) = (first + k as i32, triangles[k]);
                    *count += 1;
                }
            }
        }
    }
}
