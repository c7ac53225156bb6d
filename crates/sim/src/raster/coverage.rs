//! Which pixel centres a triangle covers, by exact edge functions.

use evpose_core::Plane;

use super::fragment::{Fragment, PixelRect};
use super::project::{SUBPIXEL, ScreenVertex};

/// Twice the signed area of `a`, `b`, `p` in squared sub-pixels, positive if clockwise on screen.
fn edge(a: ScreenVertex, b: ScreenVertex, px: i32, py: i32) -> i64 {
    let (dx, dy) = (i64::from(b.x - a.x), i64::from(b.y - a.y));
    dx * i64::from(py - a.y) - dy * i64::from(px - a.x)
}

/// Whether a centre exactly on the edge from `a` to `b` belongs to the triangle.
fn owns_its_edge(a: ScreenVertex, b: ScreenVertex) -> bool {
    let (left, top) = (b.y < a.y, b.y == a.y && b.x > a.x);
    left || top
}

/// A triangle set up for filling, clockwise on screen.
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    corners: [ScreenVertex; 3],
    inverse_area: f32,
    /// Whether the second and third corner were swapped to make it clockwise.
    swapped: bool,
}

impl Triangle {
    /// Sets up a face, if it has an area. Outward faces are counter-clockwise seen with y up; with
    /// `cull` the others are left out.
    #[inline]
    pub(super) fn new(corners: [ScreenVertex; 3], cull: bool) -> Option<Self> {
        let [a, b, c] = corners;
        let area = edge(a, b, c.x, c.y);
        if area < 0 {
            // y points down on the image, so this is a face that looks at the camera.
            let inverse_area = 1.0 / -area as f32;
            Some(Self { corners: [a, c, b], inverse_area, swapped: true })
        } else if area > 0 && !cull {
            Some(Self { corners, inverse_area: 1.0 / area as f32, swapped: false })
        } else {
            None
        }
    }
}

/// The image that triangles are filled into.
#[derive(Debug)]
pub(super) struct Viewport<'a> {
    fragments: &'a mut Plane<Fragment>,
    whole: PixelRect,
}

impl<'a> Viewport<'a> {
    pub(super) fn new(fragments: &'a mut Plane<Fragment>, whole: PixelRect) -> Self {
        Self { fragments, whole }
    }

    /// Writes `face` wherever the triangle is nearer than what is there; of two at the same depth
    /// the first stays. `face_from_triangle` maps the barycentric coordinates of the triangle to
    /// those of the face.
    #[inline]
    pub(super) fn fill(
        &mut self,
        triangle: &Triangle,
        face: u32,
        face_from_triangle: impl Fn([f32; 2]) -> [f32; 2],
    ) {
        let [a, b, c] = triangle.corners;
        let rect = PixelRect::of_centres(
            a.x.min(b.x).min(c.x),
            a.y.min(b.y).min(c.y),
            a.x.max(b.x).max(c.x),
            a.y.max(b.y).max(c.y),
            self.whole,
        );
        if rect.is_empty() {
            return;
        }
        let centre = |pixel: usize| pixel as i32 * SUBPIXEL + SUBPIXEL / 2;
        let (px, py) = (centre(rect.left), centre(rect.top));
        // A centre on an edge counts where the edge is owned: the others start one step lower.
        let start = |from, to| edge(from, to, px, py) - i64::from(!owns_its_edge(from, to));
        let mut row_a = start(b, c);
        let mut row_b = start(c, a);
        let mut row_c = start(a, b);
        let step_x =
            |from: ScreenVertex, to: ScreenVertex| -i64::from(to.y - from.y) * i64::from(SUBPIXEL);
        let step_y =
            |from: ScreenVertex, to: ScreenVertex| i64::from(to.x - from.x) * i64::from(SUBPIXEL);
        let (xa, xb, xc) = (step_x(b, c), step_x(c, a), step_x(a, b));
        let (ya, yb, yc) = (step_y(b, c), step_y(c, a), step_y(a, b));
        let slope_b = b.inverse_depth - a.inverse_depth;
        let slope_c = c.inverse_depth - a.inverse_depth;
        for y in rect.top..rect.bottom {
            let (mut ea, mut eb, mut ec) = (row_a, row_b, row_c);
            for fragment in &mut self.fragments.row_mut(y)[rect.left..rect.right] {
                if (ea | eb | ec) >= 0 {
                    let linear_b = eb as f32 * triangle.inverse_area;
                    let linear_c = ec as f32 * triangle.inverse_area;
                    let inverse_depth = a.inverse_depth + linear_b * slope_b + linear_c * slope_c;
                    if inverse_depth > fragment.inverse_depth {
                        let depth = 1.0 / inverse_depth;
                        let second = linear_b * b.inverse_depth * depth;
                        let third = linear_c * c.inverse_depth * depth;
                        let barycentric =
                            if triangle.swapped { [third, second] } else { [second, third] };
                        let barycentric = face_from_triangle(barycentric);
                        *fragment = Fragment { inverse_depth, face, barycentric };
                    }
                }
                ea += xa;
                eb += xb;
                ec += xc;
            }
            row_a += ya;
            row_b += yb;
            row_c += yc;
        }
    }
}
