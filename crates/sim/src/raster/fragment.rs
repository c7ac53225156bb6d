//! Fragments: the face of a pixel and the position on it.

use evpose_core::SensorSize;

use super::project::SUBPIXEL;

/// Visible surface of one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fragment {
    /// 1 / depth in 1/m; zero where no face covers the pixel.
    pub inverse_depth: f32,
    /// Index of the face.
    pub face: u32,
    /// Perspective-correct barycentric coordinates of the second and third vertex of the face.
    pub barycentric: [f32; 2],
}

impl Fragment {
    /// No surface.
    pub const NONE: Self = Self { inverse_depth: 0.0, face: 0, barycentric: [0.0; 2] };

    /// Whether a face covers the pixel.
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
    #[inline(always)]
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
