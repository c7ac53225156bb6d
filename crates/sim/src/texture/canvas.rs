//! Drawing primitives of the procedural images.

use std::f32::consts::TAU;

use evpose_core::{CounterRng, Plane};
use glam::{Vec2, Vec3A};

/// An image being painted. Coordinates are in texels from the top-left corner, y down; what falls
/// outside is left out.
#[derive(Debug, Clone)]
pub(super) struct Canvas {
    image: Plane<Vec3A>,
}

/// A rectangle with sides parallel to the image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rect {
    pub left: f32,
    pub top: f32,
    pub right: f32,
    pub bottom: f32,
}

impl Rect {
    pub(super) fn new(left: f32, top: f32, right: f32, bottom: f32) -> Self {
        Self { left, top, right, bottom }
    }

    /// The rectangle without a border of the given width.
    pub(super) fn inset(self, border: f32) -> Self {
        let Self { left, top, right, bottom } = self;
        Self::new(left + border, top + border, right - border, bottom - border)
    }

    pub(super) fn width(self) -> f32 {
        self.right - self.left
    }

    pub(super) fn height(self) -> f32 {
        self.bottom - self.top
    }
}

impl Canvas {
    pub(super) fn filled(width: usize, height: usize, colour: Vec3A) -> Self {
        Self { image: Plane::filled(width, height, colour) }
    }

    pub(super) fn width(&self) -> f32 {
        self.image.width() as f32
    }

    pub(super) fn height(&self) -> f32 {
        self.image.height() as f32
    }

    pub(super) fn whole(&self) -> Rect {
        Rect::new(0.0, 0.0, self.width(), self.height())
    }

    pub(super) fn finish(self) -> Plane<Vec3A> {
        self.image
    }

    /// Repaints the texels whose centres lie in `area` with a function of position and colour.
    pub(super) fn paint(&mut self, area: Rect, mut brush: impl FnMut(Vec2, Vec3A) -> Vec3A) {
        // Texels whose centre is inside: adjacent areas neither overlap nor leave gaps.
        let first = |edge: f32| (edge - 0.5).ceil().max(0.0) as usize;
        let (left, right) = (first(area.left), first(area.right).min(self.image.width()));
        for y in first(area.top)..first(area.bottom).min(self.image.height()) {
            let row = self.image.row_mut(y);
            for (x, texel) in row.iter_mut().enumerate().take(right).skip(left) {
                *texel = brush(Vec2::new(x as f32 + 0.5, y as f32 + 0.5), *texel);
            }
        }
    }

    pub(super) fn rect(&mut self, area: Rect, colour: Vec3A) {
        self.paint(area, |_, _| colour);
    }

    /// An ellipse turned by `angle_rad`; `brush` gets the position inside it, in the unit disc.
    pub(super) fn ellipse(
        &mut self,
        centre: Vec2,
        radii: Vec2,
        angle_rad: f32,
        mut brush: impl FnMut(Vec2, Vec3A) -> Vec3A,
    ) {
        // The square around the circle of the larger radius holds the ellipse at any angle.
        let (reach, turn) = (radii.max_element(), Vec2::from_angle(-angle_rad));
        let area =
            Rect::new(centre.x - reach, centre.y - reach, centre.x + reach, centre.y + reach);
        self.paint(area, |position, old| {
            let inside = turn.rotate(position - centre) / radii;
            if inside.length_squared() <= 1.0 { brush(inside, old) } else { old }
        });
    }

    /// A straight stroke with square ends.
    pub(super) fn stroke(&mut self, from: Vec2, to: Vec2, width: f32, colour: Vec3A) {
        let half = Vec2::splat(0.5 * width);
        let (low, high) = (from.min(to) - half, from.max(to) + half);
        let along = (to - from).normalize_or_zero();
        let length = (to - from).length();
        self.paint(Rect::new(low.x, low.y, high.x, high.y), |position, old| {
            let offset = position - from;
            let (s, across) = (offset.dot(along), offset.perp_dot(along));
            let inside = (0.0..=length).contains(&s) && across.abs() <= 0.5 * width;
            if inside { colour } else { old }
        });
    }

    /// Multiplies every texel by `1 + strength · field`.
    ///
    /// # Panics
    /// If the field has another size.
    pub(super) fn modulate(&mut self, field: &Plane<f32>, strength: f32) {
        assert_eq!(field.data().len(), self.image.data().len(), "a field of another size");
        for (texel, value) in self.image.data_mut().iter_mut().zip(field.data()) {
            *texel *= 1.0 + strength * value;
        }
    }
}

/// A random colour with saturation and value in the given ranges.
pub(super) fn random_colour(
    rng: &mut CounterRng,
    saturation: (f32, f32),
    value: (f32, f32),
) -> Vec3A {
    let hue = rng.uniform(0.0, TAU);
    let saturation = rng.uniform(saturation.0, saturation.1);
    let value = rng.uniform(value.0, value.1);
    // A colour wheel of three cosines: smooth, and accurate enough for backgrounds.
    let wheel = Vec3A::new(hue.cos(), (hue - TAU / 3.0).cos(), (hue + TAU / 3.0).cos());
    (Vec3A::ONE + (wheel - 1.0) * 0.5 * saturation) * value
}
