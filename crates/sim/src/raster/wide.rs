//! Triangles of any size, one by one: faces with long edges, and parts of those that the near plane
//! cuts.

use super::fragment::PixelRect;
use super::project::{SUBPIXEL, ScreenVertex};
use super::triangle::{Triangle, pack_xy};
use super::visibility::VisibilityBuffer;

/// Edge function: the side of a directed edge that a pixel centre is on, and the distance.
///
/// # Model
/// Twice the signed area of the edge's ends and the centre in squared sub-pixels, positive to the
/// right of the edge as y points down. A centre exactly on the edge counts where the edge is a top
/// or left one: the others are one step lower.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Edge {
    /// At the first pixel of the triangle's rectangle.
    start: i64,
    /// From a pixel to the one at its right.
    step_x: i64,
    /// From a pixel to the one below.
    step_y: i64,
}

impl Edge {
    fn new(from: ScreenVertex, to: ScreenVertex, (left, top): (i32, i32)) -> Self {
        let (dx, dy) = (to.x() - from.x(), to.y() - from.y());
        let is_owned = dy < 0 || (dy == 0 && dx > 0);
        let centre = |pixel: i32| pixel * SUBPIXEL + SUBPIXEL / 2;
        let start = twice_area(dx, dy, centre(left) - from.x(), centre(top) - from.y());
        Self {
            start: start - i64::from(!is_owned),
            step_x: -i64::from(dy) * i64::from(SUBPIXEL),
            step_y: i64::from(dx) * i64::from(SUBPIXEL),
        }
    }

    /// At a pixel of the rectangle, counted from its first.
    fn at(&self, x: usize, y: usize) -> i64 {
        self.start + x as i64 * self.step_x + y as i64 * self.step_y
    }

    /// Bits of the largest value in a rectangle of this size, sign included.
    fn bits(&self, width: usize, height: usize) -> u32 {
        let corners = [(0, 0), (width, 0), (0, height), (width, height)];
        let values = corners.map(|(x, y)| self.at(x, y)).into_iter();
        let largest = values.chain([self.step_x, self.step_y]).map(i64::unsigned_abs).max();
        65 - largest.unwrap_or(0).leading_zeros()
    }
}

/// Twice the signed area of two directed edges from one point.
fn twice_area(dx: i32, dy: i32, to_x: i32, to_y: i32) -> i64 {
    i64::from(dx) * i64::from(to_y) - i64::from(dy) * i64::from(to_x)
}

/// Setup of a triangle of any size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wide {
    /// Setup for the shading pass.
    pub(super) triangle: Triangle,
    /// Edge functions opposite to the three corners.
    edges: [Edge; 3],
    /// Bounding rectangle of the pixel centres.
    rect: PixelRect,
    /// 1/depth of the first corner, and its slopes along the edge functions of the others.
    inverse_depth: f32,
    slopes: [f32; 2],
}

impl Wide {
    /// Sets up a face, if it has an area and covers a pixel centre's row and column in `whole`.
    /// Outward faces are counter-clockwise seen with y up; with `cull` the others are left out.
    pub(super) fn new(
        face: u32,
        corners: [u32; 3],
        on_screen: [ScreenVertex; 3],
        cull: bool,
        whole: PixelRect,
    ) -> Option<Self> {
        let ([a, mut b, mut c], [first, mut second, mut third]) = (on_screen, corners);
        let mut area = twice_area(b.x() - a.x(), b.y() - a.y(), c.x() - a.x(), c.y() - a.y());
        // In a closed mesh others cover what looks away; without an area there is nothing to see.
        if area >= 0 && (cull || area == 0) {
            return None;
        }
        if area < 0 {
            // y points down on the image, so this is a face that looks at the camera.
            area = -area;
            (b, c) = (c, b);
            (second, third) = (third, second);
        }
        let min = |get: fn(ScreenVertex) -> i32| get(a).min(get(b)).min(get(c));
        let max = |get: fn(ScreenVertex) -> i32| get(a).max(get(b)).max(get(c));
        let rect = PixelRect::of_centres(
            min(ScreenVertex::x),
            min(ScreenVertex::y),
            max(ScreenVertex::x),
            max(ScreenVertex::y),
            whole,
        );
        if rect.is_empty() {
            return None;
        }
        // Relative to the rectangle's corner, values are small and need few bits.
        let origin = (rect.left as i32, rect.top as i32);
        let edges = [Edge::new(b, c, origin), Edge::new(c, a, origin), Edge::new(a, b, origin)];
        let (width, height) = (rect.right - rect.left, rect.bottom - rect.top);
        let bits = edges[1..].iter().map(|edge| edge.bits(width, height)).max();
        // Interpolation needs no exact edges: low bits are dropped until 31 hold the rest.
        let shift = bits.unwrap_or(0).saturating_sub(31);
        let row = |edge: &Edge, last: i32| {
            let [start, step_x, step_y] =
                [edge.start, edge.step_x, edge.step_y].map(|value| (value >> shift) as i32);
            [start, step_x, step_y, last]
        };
        let inverse_area = 1.0 / area as f32;
        let per_unit = inverse_area * (1_u64 << shift) as f32;
        Some(Self {
            triangle: Triangle {
                second: row(&edges[1], pack_xy(rect.left, rect.top)),
                third: row(&edges[2], per_unit.to_bits() as i32),
                corners: [first, second, third],
                face,
            },
            edges,
            rect,
            inverse_depth: a.inverse_depth(),
            slopes: [b, c].map(|v| (v.inverse_depth() - a.inverse_depth()) * inverse_area),
        })
    }
}

impl VisibilityBuffer {
    /// Rasterises a triangle with index `number` pixel by pixel, with a depth test; of two at the
    /// same depth the first stays.
    pub(super) fn fill_wide(&mut self, set_up: &Wide, number: u32) {
        let Wide { edges, rect, inverse_depth, slopes, .. } = set_up;
        for y in rect.top..rect.bottom {
            for x in rect.left..rect.right {
                let values = edges.map(|edge| edge.at(x - rect.left, y - rect.top));
                let inverse_depth =
                    inverse_depth + values[1] as f32 * slopes[0] + values[2] as f32 * slopes[1];
                if values.iter().all(|&value| value >= 0) {
                    self.show(x, y, inverse_depth, number);
                }
            }
        }
    }
}
