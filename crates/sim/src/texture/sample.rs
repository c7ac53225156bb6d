//! An RGB image with linear filtering that repeats beyond its borders.

use evpose_core::Plane;
use glam::{Vec2, Vec3A};

/// An image of colours, mostly in [0, 1]. Rows go downwards from v = 0.
///
/// Whether the values are linear or gamma-encoded is the user's to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    image: Plane<Vec3A>,
}

impl Texture {
    /// Takes an image.
    ///
    /// # Panics
    /// If it is empty.
    pub fn from_plane(image: Plane<Vec3A>) -> Self {
        assert!(!image.data().is_empty(), "a texture without texels");
        Self { image }
    }

    /// Takes eight-bit texels, row by row; `None` unless there are `width * height` of them.
    pub fn from_rgb8(width: usize, height: usize, rgb: &[u8]) -> Option<Self> {
        let (texels, rest) = rgb.as_chunks::<3>();
        let colours = texels.iter().map(|&code| Vec3A::from_array(code.map(f32::from)) / 255.0);
        let image = Plane::from_vec(width, height, colours.collect()).ok()?;
        (rest.is_empty() && width * height > 0).then(|| Self::from_plane(image))
    }

    /// The texels.
    pub fn image(&self) -> &Plane<Vec3A> {
        &self.image
    }

    /// The colour at `uv`, interpolated between the centres of four texels; the image repeats with
    /// period 1.
    #[inline]
    pub fn sample(&self, uv: Vec2) -> Vec3A {
        let (left, right, fx) = neighbours(uv.x, self.image.width());
        let (above, below, fy) = neighbours(uv.y, self.image.height());
        let (above, below) = (self.image.row(above), self.image.row(below));
        let top = above[left] + (above[right] - above[left]) * fx;
        let bottom = below[left] + (below[right] - below[left]) * fx;
        top + (bottom - top) * fy
    }
}

/// The two texels around a coordinate, and the weight of the second. Texel centres lie at
/// half-integers.
#[inline]
fn neighbours(coordinate: f32, texels: usize) -> (usize, usize, f32) {
    let n = texels as f32;
    // `floor` by hand: without SSE4.1 it is a call.
    let truncated = coordinate as i32;
    let whole = truncated - i32::from(truncated as f32 > coordinate);
    // Shifted by one texel, so that the position is not negative and truncation is `floor`.
    let position = (coordinate - whole as f32) * n + 0.5;
    let second = position as usize;
    let weight = position - second as f32;
    let last = texels - 1;
    let left = if second == 0 || second > last + 1 { last } else { second - 1 };
    let right = if second > last { 0 } else { second };
    (left, right, weight)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use super::*;

    fn checker() -> Texture {
        Texture::from_rgb8(2, 1, &[0, 0, 0, 255, 51, 102]).unwrap()
    }

    #[test]
    fn texel_centres_return_the_texel() {
        let texture = checker();
        assert_eq!(texture.sample(Vec2::new(0.25, 0.5)), Vec3A::ZERO);
        let second = texture.sample(Vec2::new(0.75, 0.5));
        assert!((second - Vec3A::new(1.0, 0.2, 0.4)).length() < 1e-6);
    }

    #[test]
    fn between_centres_the_colour_is_linear_and_repeats() {
        let texture = checker();
        for (u, want) in [(0.375, 0.25), (0.5, 0.5), (0.0, 0.5), (1.0, 0.5), (-0.125, 0.75)] {
            let got = texture.sample(Vec2::new(u, 0.3)).x;
            assert!((got - want).abs() < 1e-6, "{u}: {got}");
            let far = texture.sample(Vec2::new(u + 7.0, -3.7)).x;
            assert!((far - want).abs() < 1e-5, "{u}: {far}");
        }
    }

    #[test]
    fn the_wrong_number_of_texels_is_refused() {
        assert_eq!(Texture::from_rgb8(2, 2, &[0; 9]), None);
        assert_eq!(Texture::from_rgb8(1, 1, &[0; 4]), None);
        assert_eq!(Texture::from_rgb8(0, 0, &[]), None);
    }
}
