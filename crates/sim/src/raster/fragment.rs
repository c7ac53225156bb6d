//! What each pixel sees: the nearest face, and where on it.

use evpose_core::{Plane, SensorSize};

use super::clip::clip_to_near_plane;
use super::coverage::{Triangle, Viewport};
use super::project::{SUBPIXEL, ScreenVertex, project};
use super::{Camera, Mesh};

/// The surface seen by one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fragment {
    /// 1 / depth in 1/m; zero where the pixel sees the background.
    pub inverse_depth: f32,
    /// Index of the face.
    pub face: u32,
    /// Perspective-correct barycentric coordinates of the second and third vertex of the face.
    pub barycentric: [f32; 2],
}

impl Fragment {
    /// No surface.
    pub const NONE: Self = Self { inverse_depth: 0.0, face: 0, barycentric: [0.0; 2] };

    /// Whether the pixel sees a surface.
    pub fn is_covered(&self) -> bool {
        self.inverse_depth > 0.0
    }
}

/// A half-open rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelRect {
    /// First column inside.
    pub left: usize,
    /// First row inside.
    pub top: usize,
    /// First column after.
    pub right: usize,
    /// First row after.
    pub bottom: usize,
}

impl PixelRect {
    /// No pixel.
    pub const EMPTY: Self = Self { left: 0, top: 0, right: 0, bottom: 0 };

    /// All pixels of a sensor.
    pub fn whole(sensor: SensorSize) -> Self {
        let (right, bottom) = (usize::from(sensor.width), usize::from(sensor.height));
        Self { left: 0, top: 0, right, bottom }
    }

    /// Whether no pixel lies inside.
    pub fn is_empty(self) -> bool {
        self.left >= self.right || self.top >= self.bottom
    }

    /// The pixels of `whole` whose centres lie in a closed rectangle of snapped coordinates.
    pub(super) fn of_centres(left: i32, top: i32, right: i32, bottom: i32, whole: Self) -> Self {
        // First centre at or after the left edge, first centre after the right one.
        let first = |edge: i32| ((edge + SUBPIXEL / 2 - 1).div_euclid(SUBPIXEL)).max(0) as usize;
        let after = |edge: i32| ((edge + SUBPIXEL / 2).div_euclid(SUBPIXEL)).max(0) as usize;
        Self {
            left: first(left).max(whole.left),
            top: first(top).max(whole.top),
            right: after(right).min(whole.right),
            bottom: after(bottom).min(whole.bottom),
        }
    }
}

/// Scratch memory and result of the visibility pass.
#[derive(Debug, Clone)]
pub struct Raster {
    fragments: Plane<Fragment>,
    screen: Vec<ScreenVertex>,
    rect: PixelRect,
}

impl Raster {
    /// A raster that sees nothing yet.
    pub fn new(sensor: SensorSize) -> Self {
        Self {
            fragments: Plane::for_sensor(sensor, Fragment::NONE),
            screen: Vec::new(),
            rect: PixelRect::EMPTY,
        }
    }

    /// Draws `mesh` alone: what was drawn before is forgotten. Returns the rectangle outside which
    /// nothing is covered.
    ///
    /// With `closed` (see [`is_closed`](super::is_closed)) the faces that look away are skipped
    /// where that cannot show: when the near plane cuts nothing open.
    ///
    /// # Panics
    /// If the camera's image is not the size this raster was made for, or a face names a vertex
    /// that the mesh does not have.
    pub fn draw(&mut self, camera: &Camera, mesh: &Mesh<'_>, closed: bool) -> PixelRect {
        let sensor = camera.sensor();
        assert!(
            usize::from(sensor.width) == self.fragments.width()
                && usize::from(sensor.height) == self.fragments.height(),
            "a raster made for another image size"
        );
        self.clear();
        let extent = project(camera, mesh.vertices_m, &mut self.screen);
        self.rect = extent.rect;
        if self.rect.is_empty() {
            return self.rect;
        }
        let cull = closed && extent.wholly_in_front;
        let mut viewport = Viewport::new(&mut self.fragments, PixelRect::whole(sensor));
        for (face, &[a, b, c]) in mesh.faces.iter().enumerate() {
            // Spelled out: `indices.map` would not be inlined.
            let (a, b, c) = (a as usize, b as usize, c as usize);
            let corners = [self.screen[a], self.screen[b], self.screen[c]];
            if extent.wholly_in_front || corners.iter().all(|c| c.inverse_depth > 0.0) {
                if let Some(triangle) = Triangle::new(corners, cull) {
                    viewport.fill(&triangle, face as u32, |barycentric| barycentric);
                }
            } else if corners.iter().any(|c| c.inverse_depth > 0.0) {
                let corners_m = [mesh.vertices_m[a], mesh.vertices_m[b], mesh.vertices_m[c]];
                clip_to_near_plane(camera, corners_m, |corners, face_from_part| {
                    if let Some(triangle) = Triangle::new(corners, false) {
                        viewport.fill(&triangle, face as u32, face_from_part);
                    }
                });
            }
        }
        self.rect
    }

    /// What each pixel sees.
    pub fn fragments(&self) -> &Plane<Fragment> {
        &self.fragments
    }

    /// The rectangle outside which nothing is covered.
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    fn clear(&mut self) {
        let PixelRect { left, top, right, bottom } = self.rect;
        for y in top..bottom {
            self.fragments.row_mut(y)[left..right].fill(Fragment::NONE);
        }
    }
}
