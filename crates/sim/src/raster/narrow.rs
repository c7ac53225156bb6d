//! Narrow triangles, whose edge functions fit in 32 bits (nearly all): set up eight at a time, and
//! filled eight pixels of a row at a time.

use evpose_cpu::{LANES_8, Lanes8};

use super::fragment::PixelRect;
use super::project::{SUBPIXEL, SUBPIXEL_BITS};
use super::triangle::{pack_xy_lanes, unpack_xy};
use super::visibility::VisibilityBuffer;

/// Longest side of a triangle's bounding box, in sub-pixels, whose edge functions fit in 32 bits
/// wherever they are evaluated: in its rectangle, and up to [`LANES_8`] pixels to the right of it.
pub(super) const MAX_NARROW_EXTENT: i32 = 30_000;

/// Setup of eight triangles, each a row of every table. Edge functions as in
/// [`Wide`](super::wide::Wide).
#[derive(Debug, Default)]
pub(super) struct Eight {
    /// Edge function opposite to the first corner: value at the first pixel, step to the right,
    /// step down; then `right + bottom·2¹⁶`, the end of the rectangle.
    first: [[i32; 4]; LANES_8],
    /// As in [`Triangle`](super::triangle::Triangle).
    pub(super) second: [[i32; 4]; LANES_8],
    pub(super) third: [[i32; 4]; LANES_8],
    /// Bits of 1/depth of the first corner, and of its slopes along the second and third edge
    /// function; zero.
    depth: [[i32; 4]; LANES_8],
    /// Bit mask of the triangles that may cover a pixel.
    pub(super) may_cover: u32,
    /// Bit mask of the triangles whose second and third corner were swapped.
    pub(super) is_turned: u32,
    /// Bit mask of the triangles before the near plane that are too wide, and not set up.
    pub(super) is_wide: u32,
}

/// Corners of eight triangles on screen.
pub(super) type EightCorners<'a> = [&'a [i32; 4]; LANES_8];

#[derive(Clone, Copy)]
struct Corner<L: Lanes8> {
    x: L::I,
    y: L::I,
    /// The bits of 1/depth.
    inverse_depth: L::I,
}

impl<L: Lanes8> Corner<L> {
    #[inline(always)]
    fn new(l: L, vertices: EightCorners<'_>) -> Self {
        let [x, y, inverse_depth, _] = l.gather_columns(vertices);
        Self { x, y, inverse_depth }
    }

    #[inline(always)]
    fn select(l: L, mask: L::I, a: Self, b: Self) -> Self {
        Self {
            x: l.select(mask, a.x, b.x),
            y: l.select(mask, a.y, b.y),
            inverse_depth: l.select(mask, a.inverse_depth, b.inverse_depth),
        }
    }
}

impl Eight {
    /// Sets up eight faces whose corners are on screen. Outward faces are counter-clockwise seen
    /// with y up; with `cull` the others are left out, and always those without an area, those that
    /// cover no pixel centre's row and column in `whole`, and those with a corner that the near
    /// plane hides.
    #[inline(always)]
    pub(super) fn set_up<L: Lanes8>(
        &mut self,
        l: L,
        [a, b, c]: [EightCorners<'_>; 3],
        cull: bool,
        whole: PixelRect,
    ) {
        let (a, b, c) = (Corner::new(l, a), Corner::new(l, b), Corner::new(l, c));
        let (zero, one) = (l.splat_i(0), l.splat_i(1));
        // 1/depth is not negative, and neither are its bits.
        let farthest = l.min_i(l.min_i(a.inverse_depth, b.inverse_depth), c.inverse_depth);
        let is_in_front = l.gt_i(farthest, zero);
        let (left, right) = (min3(l, a.x, b.x, c.x), max3(l, a.x, b.x, c.x));
        let (top, bottom) = (min3(l, a.y, b.y, c.y), max3(l, a.y, b.y, c.y));
        let extent = l.max_i(l.sub_i(right, left), l.sub_i(bottom, top));
        let is_wide = l.gt_i(extent, l.splat_i(MAX_NARROW_EXTENT));

        // Wraps for wide triangles, which are masked out below.
        let area = l.sub_i(
            l.mul_i(l.sub_i(b.x, a.x), l.sub_i(c.y, a.y)),
            l.mul_i(l.sub_i(b.y, a.y), l.sub_i(c.x, a.x)),
        );
        // y points down on the image, so these are the faces that look at the camera.
        let is_turned = l.gt_i(zero, area);
        let turns = if cull { zero } else { l.gt_i(area, zero) };
        let is_seen = l.and(is_in_front, l.or(is_turned, turns));
        let area = l.max_i(area, l.sub_i(zero, area));
        let (b, c) = (Corner::select(l, is_turned, c, b), Corner::select(l, is_turned, b, c));

        // As `PixelRect::of_centres`.
        let left = l.max_i(pixel(l, left, SUBPIXEL / 2 - 1), l.splat_i(whole.left as i32));
        let top = l.max_i(pixel(l, top, SUBPIXEL / 2 - 1), l.splat_i(whole.top as i32));
        let right = l.min_i(pixel(l, right, SUBPIXEL / 2), l.splat_i(whole.right as i32));
        let bottom = l.min_i(pixel(l, bottom, SUBPIXEL / 2), l.splat_i(whole.bottom as i32));
        let has_centres = l.and(l.gt_i(right, left), l.gt_i(bottom, top));

        let (x, y) = (centre(l, left), centre(l, top));
        let of_first = edge(l, b, c, [x, y]);
        let of_second = edge(l, c, a, [x, y]);
        let of_third = edge(l, a, b, [x, y]);
        let per_area = l.div(l.splat(1.0), l.to_f(l.max_i(area, one)));
        let inverse_depth = l.from_bits(a.inverse_depth);
        let slope_b = l.mul(l.sub(l.from_bits(b.inverse_depth), inverse_depth), per_area);
        let slope_c = l.mul(l.sub(l.from_bits(c.inverse_depth), inverse_depth), per_area);
        let (begin, end) = (pack_xy_lanes(l, left, top), pack_xy_lanes(l, right, bottom));
        l.scatter_columns([of_first[0], of_first[1], of_first[2], end], &mut self.first);
        l.scatter_columns([of_second[0], of_second[1], of_second[2], begin], &mut self.second);
        l.scatter_columns(
            [of_third[0], of_third[1], of_third[2], l.to_bits(per_area)],
            &mut self.third,
        );
        l.scatter_columns(
            [a.inverse_depth, l.to_bits(slope_b), l.to_bits(slope_c), zero],
            &mut self.depth,
        );
        self.may_cover = l.to_bitmask(l.and_not(l.and(is_seen, has_centres), is_wide));
        self.is_turned = l.to_bitmask(is_turned);
        self.is_wide = l.to_bitmask(l.and(is_in_front, is_wide));
    }
}

#[inline(always)]
fn min3<L: Lanes8>(l: L, a: L::I, b: L::I, c: L::I) -> L::I {
    l.min_i(l.min_i(a, b), c)
}

#[inline(always)]
fn max3<L: Lanes8>(l: L, a: L::I, b: L::I, c: L::I) -> L::I {
    l.max_i(l.max_i(a, b), c)
}

/// Whole pixels of positions plus an offset in sub-pixels.
#[inline(always)]
fn pixel<L: Lanes8>(l: L, position: L::I, added: i32) -> L::I {
    l.shift_right_signed::<{ SUBPIXEL_BITS as i32 }>(l.add_i(position, l.splat_i(added)))
}

/// The centres of pixels, in sub-pixels.
#[inline(always)]
fn centre<L: Lanes8>(l: L, pixel: L::I) -> L::I {
    l.add_i(l.mul_i(pixel, l.splat_i(SUBPIXEL)), l.splat_i(SUBPIXEL / 2))
}

/// Eight edge functions at the pixel centres (x, y), and their steps to the right and down.
#[inline(always)]
fn edge<L: Lanes8>(l: L, from: Corner<L>, to: Corner<L>, [x, y]: [L::I; 2]) -> [L::I; 3] {
    let zero = l.splat_i(0);
    let (dx, dy) = (l.sub_i(to.x, from.x), l.sub_i(to.y, from.y));
    let down = l.mul_i(dx, l.sub_i(y, from.y));
    let right = l.mul_i(dy, l.sub_i(x, from.x));
    // Top-left rule: other edges are lowered by one. The mask is -1, so subtracting it adds one.
    let is_level = l.and_not(l.gt_i(dx, zero), l.or(l.gt_i(dy, zero), l.gt_i(zero, dy)));
    let is_owned = l.or(l.gt_i(zero, dy), is_level);
    let start = l.sub_i(l.sub_i(l.sub_i(down, right), l.splat_i(1)), is_owned);
    let steps = l.splat_i(SUBPIXEL);
    [start, l.mul_i(l.sub_i(zero, dy), steps), l.mul_i(dx, steps)]
}

impl VisibilityBuffer {
    /// Rasterises triangle `k` of `eight` with index `number` and a depth test; of two at the same
    /// depth the first stays.
    ///
    /// Pixel centres outside of the rectangle are outside of an edge as well.
    #[inline(always)]
    pub(super) fn fill<L: Lanes8>(&mut self, l: L, eight: &Eight, k: usize, number: u32) {
        let (first, second) = (&eight.first[k], &eight.second[k]);
        let (third, depth) = (&eight.third[k], &eight.depth[k]);
        let ((left, top), (right, bottom)) = (unpack_xy(second[3]), unpack_xy(first[3]));
        let (a, b) = (EdgeAlong::new(l, first), EdgeAlong::new(l, second));
        let c = EdgeAlong::new(l, third);
        let inverse_depth = l.from_bits(l.splat_i(depth[0]));
        let (slope_b, slope_c) =
            (l.from_bits(l.splat_i(depth[1])), l.from_bits(l.splat_i(depth[2])));
        let number = l.splat_i(number as i32);
        let plane = DepthPlane { inverse_depth, slope_b, slope_c };
        let (mut at_a, mut at_b, mut at_c) = (a.start, b.start, c.start);
        for (depths, indices) in self.rows_mut(top..bottom) {
            let Some(seen) = eight_mut(depths, indices, left) else { return };
            plane.show(l, [at_a, at_b, at_c], number, seen);
            if right - left > LANES_8 {
                // To the right of the rectangle they may wrap, in pixels that are not read.
                let (mut on_a, mut on_b, mut on_c) = (at_a, at_b, at_c);
                for x in (left + LANES_8..right).step_by(LANES_8) {
                    on_a = l.add_i(on_a, a.chunk(l));
                    on_b = l.add_i(on_b, b.chunk(l));
                    on_c = l.add_i(on_c, c.chunk(l));
                    let Some(seen) = eight_mut(depths, indices, x) else { return };
                    plane.show(l, [on_a, on_b, on_c], number, seen);
                }
            }
            // Edge functions are linear: one row further down is one addition.
            at_a = l.add_i(at_a, a.step_y);
            at_b = l.add_i(at_b, b.step_y);
            at_c = l.add_i(at_c, c.step_y);
        }
    }
}

/// Eight pixels: bits of 1/depth, and triangle indices.
type EightPixels<'a> = (&'a mut [i32; LANES_8], &'a mut [i32; LANES_8]);

#[inline(always)]
fn eight_mut<'a>(
    depths: &'a mut [i32],
    indices: &'a mut [i32],
    x: usize,
) -> Option<EightPixels<'a>> {
    let pixels = x..x + LANES_8;
    let depths = depths.get_mut(pixels.clone())?.first_chunk_mut()?;
    Some((depths, indices.get_mut(pixels)?.first_chunk_mut()?))
}

/// Plane equation of 1/depth over a triangle.
#[derive(Clone, Copy)]
struct DepthPlane<L: Lanes8> {
    inverse_depth: L::F,
    slope_b: L::F,
    slope_c: L::F,
}

impl<L: Lanes8> DepthPlane<L> {
    /// Depth-tests triangle `number` at eight pixels with these edge functions.
    #[inline(always)]
    fn show(self, l: L, [at_a, at_b, at_c]: [L::I; 3], number: L::I, pixels: EightPixels<'_>) {
        let (nearest, seen) = pixels;
        let is_outside = l.sign_mask(l.or(l.or(at_a, at_b), at_c));
        let of_b = l.mul(l.to_f(at_b), self.slope_b);
        let of_c = l.mul(l.to_f(at_c), self.slope_c);
        let bits = l.to_bits(l.add(l.add(self.inverse_depth, of_b), of_c));
        // Positive floats compare as their bits do; zero is infinitely far.
        let bits = l.and_not(bits, is_outside);
        let behind = l.load_i(*nearest);
        let is_seen = l.gt_i(bits, behind);
        *seen = l.store_i(l.select(is_seen, number, l.load_i(*seen)));
        *nearest = l.store_i(l.max_i(bits, behind));
    }
}

/// One edge function along a row.
#[derive(Clone, Copy)]
struct EdgeAlong<L: Lanes8> {
    /// At the first pixels of the rectangle.
    start: L::I,
    step_x: L::I,
    step_y: L::I,
}

impl<L: Lanes8> EdgeAlong<L> {
    #[inline(always)]
    fn new(l: L, &[start, step_x, step_y, _]: &[i32; 4]) -> Self {
        let step_x = l.splat_i(step_x);
        let ramp = l.load_i([0, 1, 2, 3, 4, 5, 6, 7]);
        Self {
            start: l.add_i(l.splat_i(start), l.mul_i(ramp, step_x)),
            step_x,
            step_y: l.splat_i(step_y),
        }
    }

    /// Over [`LANES_8`] pixels.
    #[inline(always)]
    fn chunk(&self, l: L) -> L::I {
        l.mul_i(self.step_x, l.splat_i(LANES_8 as i32))
    }
}
