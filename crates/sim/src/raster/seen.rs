//! The list of the pixels that see a surface, which shading goes through.

use evpose_core::{LANES, LaneWork, Lanes, in_lanes};

use super::Raster;
use super::triangle::together;

/// Pixels that see a surface.
#[derive(Debug, Clone, Default)]
pub(crate) struct SeenPixels {
    /// Room for all of the image: what is seen is hard to foresee.
    places: Vec<i32>,
    triangles: Vec<i32>,
    count: usize,
}

impl SeenPixels {
    /// Lists those of `raster`, row by row.
    pub(crate) fn list(&mut self, raster: &Raster) {
        let room = raster.sensor.pixels().next_multiple_of(LANES);
        self.places.resize(room, 0);
        self.triangles.resize(room, 0);
        self.count = 0;
        in_lanes(List { raster, seen: self });
        // Those behind the last one are looked up with it.
        let behind = self.count..self.count.next_multiple_of(LANES);
        self.places[behind.clone()].fill(0);
        self.triangles[behind].fill(0);
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Column + row·2¹⁶ of each, and the number of its triangle; behind the last one are others that
    /// exist.
    pub(crate) fn eights(&self) -> impl Iterator<Item = (&[i32; LANES], &[i32; LANES])> {
        let eights = self.count.div_ceil(LANES);
        self.places.as_chunks().0.iter().zip(self.triangles.as_chunks().0).take(eights)
    }
}

struct List<'a> {
    raster: &'a Raster,
    seen: &'a mut SeenPixels,
}

impl LaneWork for List<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Raster { visibility, rect, .. } = self.raster;
        let SeenPixels { places, triangles: seen, count } = self.seen;
        for y in rect.top..rect.bottom {
            for x in (rect.left..rect.right).step_by(LANES) {
                let Some((inverse_depth, triangles)) = visibility.lanes(x, y) else { return };
                let known = u32::MAX >> (u32::BITS as usize - (rect.right - x).min(LANES));
                let is_seen = l.greater_i(l.load_i(*inverse_depth), l.splat_i(0));
                let mut left = l.mask_bits(is_seen) & known;
                let first = together(x, y);
                while left != 0 {
                    let k = left.trailing_zeros() as usize % LANES;
                    left &= left - 1;
                    (places[*count], seen[*count]) = (first + k as i32, triangles[k]);
                    *count += 1;
                }
            }
        }
    }
}
