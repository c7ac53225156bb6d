//! Setup of a triangle that the shading pass needs to interpolate on it.

use evpose_cpu::{LANES_8, Lanes8};

/// A triangle that pixels may show.
///
/// # Model
/// The edge functions opposite to the second and third corner, over twice the area, are the affine
/// coordinates of a pixel, linear in the image. They are kept as integers, because the small
/// difference of large values counts. They are exact up to
/// [`MAX_NARROW_EXTENT`](super::narrow::MAX_NARROW_EXTENT); of longer triangles the last bits are
/// left out, and what would be outside of the triangle by that is moved to its edge.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Triangle {
    /// Edge function opposite to the second corner: value at the first pixel, step to the right,
    /// step down; then `left + top·2¹⁶` of the first pixel.
    pub(super) second: [i32; 4],
    /// The same opposite to the third corner; then the bits of one over twice the area.
    pub(super) third: [i32; 4],
    /// Its corners, clockwise on screen.
    pub(super) corners: [u32; 3],
    /// The face it is, or is part of.
    pub(super) face: u32,
}

/// Packs column and row, below 2¹⁶, into one integer: `x + y·2¹⁶`.
#[inline(always)]
pub(super) fn pack_xy(x: usize, y: usize) -> i32 {
    (x | y << 16) as i32
}

/// Inverse of [`pack_xy`].
#[inline(always)]
pub(crate) fn unpack_xy(position: i32) -> (usize, usize) {
    let position = position as u32 as usize;
    (position & 0xffff, position >> 16)
}

/// [`pack_xy`] of eight positions.
#[inline(always)]
pub(super) fn pack_xy_lanes<L: Lanes8>(l: L, x: L::I, y: L::I) -> L::I {
    l.or(x, l.mul_i(y, l.splat_i(1 << 16)))
}

/// [`unpack_xy`] of eight positions.
#[inline(always)]
pub(crate) fn unpack_xy_lanes<L: Lanes8>(l: L, positions: L::I) -> (L::I, L::I) {
    (l.and(positions, l.splat_i(0xffff)), l.shift_right::<16>(positions))
}

impl Triangle {
    /// Affine coordinates of the second and third corner at a pixel.
    pub(super) fn affine(&self, x: usize, y: usize) -> [f32; 2] {
        let (left, top) = unpack_xy(self.second[3]);
        let (x, y) = ((x as i32).wrapping_sub(left as i32), (y as i32).wrapping_sub(top as i32));
        let per_area = f32::from_bits(self.third[3] as u32);
        let [second, third] = [self.second, self.third].map(|[start, step_x, step_y, _]| {
            start.wrapping_add(x.wrapping_mul(step_x)).wrapping_add(y.wrapping_mul(step_y)) as f32
                * per_area
        });
        // Rounding may put the centre of an edge pixel a little outside.
        let second = second.clamp(0.0, 1.0);
        [second, third.max(0.0).min(1.0 - second)]
    }

    /// [`Self::affine`] at eight pixels, each of its own triangle.
    #[inline(always)]
    pub(super) fn affine_lanes<L: Lanes8>(
        l: L,
        triangles: [&Self; LANES_8],
        pixels: L::I,
    ) -> [L::F; 2] {
        // Spelled out, here and in other kernels: a map would go through memory.
        let [a, b, c, d, e, f, g, h] = triangles;
        let [start, step_x, step_y, positions] = l.gather_columns([
            &a.second, &b.second, &c.second, &d.second, &e.second, &f.second, &g.second, &h.second,
        ]);
        let (x, y) = unpack_xy_lanes(l, pixels);
        let (left, top) = unpack_xy_lanes(l, positions);
        // Relative to the rectangle's corner, so that products fit in 32 bits.
        let (x, y) = (l.sub_i(x, left), l.sub_i(y, top));
        let second = l.add_i(start, l.add_i(l.mul_i(x, step_x), l.mul_i(y, step_y)));
        let [start, step_x, step_y, per_area] = l.gather_columns([
            &a.third, &b.third, &c.third, &d.third, &e.third, &f.third, &g.third, &h.third,
        ]);
        let third = l.add_i(start, l.add_i(l.mul_i(x, step_x), l.mul_i(y, step_y)));
        let per_area = l.from_bits(per_area);
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        // A visible centre may lie outside by a rounding: weights must stay within [0, 1].
        let second = l.min(l.max(l.mul(l.to_f(second), per_area), zero), one);
        let third = l.min(l.max(l.mul(l.to_f(third), per_area), zero), l.sub(one, second));
        [second, third]
    }
}
