//! The list of covered pixels, which the shading pass iterates over.

use evpose_cpu::{Kernel8, LANES_8, Lanes8, dispatch};

use super::Raster;
use super::triangle::pack_xy;

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
        let capacity = raster.sensor.pixels().next_multiple_of(LANES_8);
        self.positions.resize(capacity, 0);
        self.triangles.resize(capacity, 0);
        self.count = 0;
        dispatch(List { raster, covered: self });
        // The last group of eight is read whole.
        let behind = self.count..self.count.next_multiple_of(LANES_8);
        self.positions[behind.clone()].fill(0);
        self.triangles[behind].fill(0);
    }

    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Groups of eight packed positions ([`pack_xy`]) and triangle indices; the last group is
    /// padded with valid ones.
    pub(crate) fn eights(&self) -> impl Iterator<Item = (&[i32; LANES_8], &[i32; LANES_8])> {
        let eights = self.count.div_ceil(LANES_8);
        self.positions.as_chunks().0.iter().zip(self.triangles.as_chunks().0).take(eights)
    }
}

struct List<'a> {
    raster: &'a Raster,
    covered: &'a mut CoveredPixels,
}

impl Kernel8 for List<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes8>(self, l: L) {
        let Raster { visibility, rect, .. } = self.raster;
        let CoveredPixels { positions, triangles: indices, count } = self.covered;
        for y in rect.top..rect.bottom {
            for x in (rect.left..rect.right).step_by(LANES_8) {
                let Some((inverse_depth, triangles)) = visibility.lanes(x, y) else { return };
                // The last eight of a row may reach beyond the rectangle.
                let known = u32::MAX >> (u32::BITS as usize - (rect.right - x).min(LANES_8));
                let is_seen = l.gt_i(l.load_i(*inverse_depth), l.splat_i(0));
                let mut left = l.to_bitmask(is_seen) & known;
                let first = pack_xy(x, y);
                while left != 0 {
                    let k = left.trailing_zeros() as usize % LANES_8;
                    left &= left - 1;
                    (positions[*count], indices[*count]) = (first + k as i32, triangles[k]);
                    *count += 1;
                }
            }
        }
    }
}
