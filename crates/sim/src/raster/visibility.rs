//! Which triangle each pixel sees: the nearest.

use evpose_core::{LANES, LaneWork, Lanes};

use super::fragment::PixelRect;
use super::triangle::{Edge, SetUp};

/// Longest side of a triangle, in sub-pixels, whose edge functions fit in 32 bits wherever they are
/// looked at: in its rectangle, and up to [`LANES`] pixels to the right of it.
const LONGEST: i32 = 30_000;

/// 1/depth and triangle of every pixel. Rows have room for [`LANES`] pixels beyond their end, which
/// nobody looks at.
#[derive(Debug, Clone)]
pub(super) struct Visibility {
    stride: usize,
    /// The bits of the numbers: in their order as long as these are not negative.
    inverse_depth: Vec<i32>,
    triangle: Vec<i32>,
}

impl Visibility {
    pub(super) fn new(width: usize, height: usize) -> Self {
        let stride = width + LANES;
        Self { stride, inverse_depth: vec![0; stride * height], triangle: vec![0; stride * height] }
    }

    /// Sees nothing in `rect` any more.
    pub(super) fn clear(&mut self, rect: PixelRect) {
        for y in rect.top..rect.bottom {
            let row = y * self.stride;
            self.inverse_depth[row + rect.left..row + rect.right].fill(0);
        }
    }

    /// The bits of 1/depth, zero where nothing is seen, and number of the triangle of the pixels of
    /// `rect` in a row.
    #[inline(always)]
    pub(super) fn row(&self, y: usize, rect: PixelRect) -> (&[i32], &[i32]) {
        let pixels = y * self.stride + rect.left..y * self.stride + rect.right;
        (&self.inverse_depth[pixels.clone()], &self.triangle[pixels])
    }

    /// Writes triangle number `number` wherever it is nearer than what is there; of two at the same
    /// depth the first stays.
    #[inline(always)]
    pub(super) fn fill<L: Lanes>(&mut self, l: L, set_up: &SetUp, number: u32) {
        if set_up.extent <= LONGEST {
            self.fill_small(l, set_up, number);
        } else {
            self.fill_large(set_up, number);
        }
    }

    /// Pixel by pixel.
    fn fill_large(&mut self, set_up: &SetUp, number: u32) {
        let SetUp { triangle, first_edge, rect, .. } = set_up;
        let [second, third] = &triangle.edges;
        for y in rect.top..rect.bottom {
            for x in rect.left..rect.right {
                let (dx, dy) = ((x - rect.left) as i64, (y - rect.top) as i64);
                let edges = [first_edge, second, third].map(|edge| edge.at(dx, dy));
                let inverse_depth = set_up.inverse_depth_at(edges[1] as f32, edges[2] as f32);
                let pixel = y * self.stride + x;
                let bits = inverse_depth.to_bits() as i32;
                if edges.iter().all(|&edge| edge >= 0) && bits > self.inverse_depth[pixel] {
                    self.inverse_depth[pixel] = bits;
                    self.triangle[pixel] = number as i32;
                }
            }
        }
    }

    /// The same, several pixels of a row at a time. Centres outside of the rectangle are outside of
    /// an edge as well.
    #[inline(always)]
    fn fill_small<L: Lanes>(&mut self, l: L, set_up: &SetUp, number: u32) {
        let SetUp { triangle, first_edge, rect, inverse_depth, slopes, .. } = set_up;
        let [second, third] = &triangle.edges;
        // Spelled out, here and in other kernels: a closure would not be inlined.
        let (a, b) = (NarrowEdge::new(l, first_edge), NarrowEdge::new(l, second));
        let c = NarrowEdge::new(l, third);
        let inverse_depth = l.splat(*inverse_depth);
        let (slope_b, slope_c) = (l.splat(slopes[0]), l.splat(slopes[1]));
        let number = l.splat_i(number as i32);
        let (mut row_a, mut row_b, mut row_c) = (a.start, b.start, c.start);
        for y in rect.top..rect.bottom {
            let (mut at_a, mut at_b, mut at_c) = (row_a, row_b, row_c);
            for x in (rect.left..rect.right).step_by(LANES) {
                let pixel = y * self.stride + x;
                let (Some(nearest), Some(seen)) = (
                    self.inverse_depth[pixel..].first_chunk_mut::<LANES>(),
                    self.triangle[pixel..].first_chunk_mut::<LANES>(),
                ) else {
                    return;
                };
                let is_outside = l.negative(l.or(l.or(at_a, at_b), at_c));
                let of_b = l.mul(l.to_f(at_b), slope_b);
                let of_c = l.mul(l.to_f(at_c), slope_c);
                let bits = l.bits(l.add(l.add(inverse_depth, of_b), of_c));
                // Numbers above zero are in the order of their bits, and nothing is nearer than zero.
                let bits = l.and_not(bits, is_outside);
                let behind = l.load_i(*nearest);
                let is_seen = l.greater_i(bits, behind);
                *seen = l.store_i(l.select(is_seen, number, l.load_i(*seen)));
                *nearest = l.store_i(l.max_i(bits, behind));
                // Behind the rectangle they may wrap, where nobody looks.
                at_a = l.add_i(at_a, a.chunk);
                at_b = l.add_i(at_b, b.chunk);
                at_c = l.add_i(at_c, c.chunk);
            }
            row_a = l.add_i(row_a, a.step_y);
            row_b = l.add_i(row_b, b.step_y);
            row_c = l.add_i(row_c, c.step_y);
        }
    }
}

/// Fills one triangle.
pub(super) struct Fill<'a> {
    pub(super) visibility: &'a mut Visibility,
    pub(super) set_up: &'a SetUp,
    pub(super) number: u32,
}

impl LaneWork for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        self.visibility.fill(l, self.set_up, self.number);
    }
}

/// An edge in 32 bits.
#[derive(Clone, Copy)]
struct NarrowEdge<L: Lanes> {
    /// At the first pixels of the rectangle.
    start: L::I,
    step_y: L::I,
    /// Over [`LANES`] pixels.
    chunk: L::I,
}

impl<L: Lanes> NarrowEdge<L> {
    #[inline(always)]
    fn new(l: L, edge: &Edge) -> Self {
        let step_x = l.splat_i(edge.step_x as i32);
        let (ramp, lanes) = (l.load_i([0, 1, 2, 3, 4, 5, 6, 7]), l.splat_i(LANES as i32));
        Self {
            start: l.add_i(l.splat_i(edge.start as i32), l.mul_i(ramp, step_x)),
            step_y: l.splat_i(edge.step_y as i32),
            chunk: l.mul_i(lanes, step_x),
        }
    }
}

impl SetUp {
    /// 1/depth where the edge functions of the second and third corner have these values.
    #[inline(always)]
    fn inverse_depth_at(&self, second: f32, third: f32) -> f32 {
        let [slope_b, slope_c] = self.slopes;
        self.inverse_depth + second * slope_b + third * slope_c
    }
}
