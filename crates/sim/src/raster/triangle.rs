//! A triangle set up for filling, by exact edge functions.

use super::fragment::PixelRect;
use super::project::{SUBPIXEL, SUBPIXEL_BITS, ScreenVertex};

/// Which side of a directed edge pixel centres are on, and how far.
///
/// # Model
/// Twice the signed area of the edge's ends and the centre in squared sub-pixels, positive to the
/// right of the edge as y points down. A centre exactly on the edge counts where the edge is a top
/// or left one: the others are one step lower.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Edge {
    /// At the first pixel of the triangle's rectangle.
    pub(super) start: i64,
    /// From a pixel to the one at its right.
    pub(super) step_x: i64,
    /// From a pixel to the one below.
    pub(super) step_y: i64,
}

impl Edge {
    #[inline(always)]
    fn new(from: ScreenVertex, to: ScreenVertex, (left, top): (i32, i32)) -> Self {
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        // All ones where the edge goes up, or level to the right; zero otherwise.
        let is_owned = ((i64::from(dy) << 32) - i64::from(dx)) >> 63;
        let centre = |pixel: i32| pixel * SUBPIXEL + SUBPIXEL / 2;
        let start = twice_area(dx, dy, centre(left) - from.x, centre(top) - from.y);
        Self {
            start: start - 1 - is_owned,
            step_x: -i64::from(dy) * i64::from(SUBPIXEL),
            step_y: i64::from(dx) * i64::from(SUBPIXEL),
        }
    }

    /// At a pixel of the rectangle, counted from its first.
    #[inline(always)]
    pub(super) fn at(&self, x: i64, y: i64) -> i64 {
        self.start + x * self.step_x + y * self.step_y
    }
}

/// Twice the signed area of two directed edges from one point.
#[inline(always)]
fn twice_area(dx: i32, dy: i32, to_x: i32, to_y: i32) -> i64 {
    i64::from(dx) * i64::from(to_y) - i64::from(dy) * i64::from(to_x)
}

/// Whether a triangle has an area, turned to the viewer with `cull`, and the row and the column of
/// a pixel centre in its bounding box.
#[inline(always)]
pub(super) fn may_cover(a: ScreenVertex, b: ScreenVertex, c: ScreenVertex, cull: bool) -> bool {
    let area = twice_area(b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y);
    let spans = |a: i32, b: i32, c: i32| {
        // A centre lies between them if it is passed on the way.
        let passed = |edge: i32| (edge + SUBPIXEL / 2) >> SUBPIXEL_BITS;
        passed(a.min(b).min(c) - 1) < passed(a.max(b).max(c))
    };
    ((area < 0) | ((area > 0) & !cull)) & spans(a.x, b.x, c.x) & spans(a.y, b.y, c.y)
}

/// What is kept of a triangle to look up where on it a pixel is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Triangle {
    /// Its corners, clockwise on screen.
    pub(super) corners: [u32; 3],
    /// The face it is, or is part of.
    pub(super) face: u32,
    /// Its first pixel.
    pub(super) left: u32,
    pub(super) top: u32,
    /// The edges opposite to the second and third corner.
    pub(super) edges: [Edge; 2],
    /// One over twice its area.
    pub(super) inverse_area: f32,
}

impl Triangle {
    /// Affine coordinates of the second and third corner at a pixel, linear in the image.
    #[inline(always)]
    pub(super) fn affine(&self, x: usize, y: usize) -> [f32; 2] {
        let (x, y) = (x as i64 - i64::from(self.left), y as i64 - i64::from(self.top));
        let [second, third] = &self.edges;
        [second.at(x, y) as f32 * self.inverse_area, third.at(x, y) as f32 * self.inverse_area]
    }
}

/// What it takes to fill a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SetUp {
    pub(super) triangle: Triangle,
    /// The edge opposite to the first corner.
    pub(super) first_edge: Edge,
    /// The pixels whose centres it can cover.
    pub(super) rect: PixelRect,
    /// Longer side of its bounding box in sub-pixels.
    pub(super) extent: i32,
    /// 1/depth of the first corner, and how much more it is per unit of the edge functions of the
    /// others.
    pub(super) inverse_depth: f32,
    pub(super) slopes: [f32; 2],
}

impl SetUp {
    /// Sets up a face, if it has an area and covers a pixel centre's row and column in `whole`.
    /// Outward faces are counter-clockwise seen with y up; with `cull` the others are left out.
    #[inline(always)]
    pub(super) fn new(
        face: u32,
        corners: [u32; 3],
        on_screen: [ScreenVertex; 3],
        cull: bool,
        whole: PixelRect,
    ) -> Option<Self> {
        let ([a, mut b, mut c], [first, mut second, mut third]) = (on_screen, corners);
        let mut area = twice_area(b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y);
        if area >= 0 && (cull || area == 0) {
            return None;
        }
        if area < 0 {
            // y points down on the image, so this is a face that looks at the camera.
            area = -area;
            (b, c) = (c, b);
            (second, third) = (third, second);
        }
        let (left, right) = (a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x));
        let (top, bottom) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
        let rect = PixelRect::of_centres(left, top, right, bottom, whole);
        if rect.is_empty() {
            return None;
        }
        let inverse_area = 1.0 / area as f32;
        let origin = (rect.left as i32, rect.top as i32);
        Some(Self {
            triangle: Triangle {
                corners: [first, second, third],
                face,
                left: rect.left as u32,
                top: rect.top as u32,
                edges: [Edge::new(c, a, origin), Edge::new(a, b, origin)],
                inverse_area,
            },
            first_edge: Edge::new(b, c, origin),
            rect,
            extent: (right - left).max(bottom - top),
            inverse_depth: a.inverse_depth,
            slopes: [b, c].map(|v| (v.inverse_depth - a.inverse_depth) * inverse_area),
        })
    }
}
