//! An RGB image with linear filtering that repeats beyond its borders.

use evpose_core::Plane;
use glam::{Vec2, Vec3A, Vec4};

/// Code value of full intensity.
const WHITE: f32 = 255.0;

/// An image of eight bits a channel, as the published textures and every photograph; small enough
/// to stay in the cache. Rows go downwards from v = 0.
///
/// Whether the values are linear or gamma-encoded is the user's to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Red, green, blue and nothing, so that a texel is one load.
    codes: Plane<[u8; 4]>,
}

impl Texture {
    /// Rounds an image in [0, 1] to eight bits.
    ///
    /// # Panics
    /// If it is empty.
    pub fn from_plane(image: &Plane<Vec3A>) -> Self {
        assert!(!image.data().is_empty(), "a texture without texels");
        let mut codes = Plane::filled(image.width(), image.height(), [0; 4]);
        for (code, rgb) in codes.data_mut().iter_mut().zip(image.data()) {
            // A cast to `u8` stops at its ends.
            let [r, g, b] = (*rgb * WHITE + 0.5).to_array().map(|c| c as u8);
            *code = [r, g, b, 0];
        }
        Self { codes }
    }

    /// Takes eight-bit texels, row by row; `None` unless there are `width * height` of them.
    pub fn from_rgb8(width: usize, height: usize, rgb: &[u8]) -> Option<Self> {
        let (texels, rest) = rgb.as_chunks::<3>();
        let codes = texels.iter().map(|&[r, g, b]| [r, g, b, 0]).collect();
        let codes = Plane::from_vec(width, height, codes).ok()?;
        (rest.is_empty() && width * height > 0).then_some(Self { codes })
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.codes.width()
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.codes.height()
    }

    /// The colour at `uv`, in [0, 1], interpolated between the centres of four texels; the image
    /// repeats with period 1.
    #[inline]
    pub fn sample(&self, uv: Vec2) -> Vec3A {
        let (left, right, fx) = neighbours(uv.x, self.codes.width());
        let (above, below, fy) = neighbours(uv.y, self.codes.height());
        let (above, below) = (self.codes.row(above), self.codes.row(below));
        let top = decode(above[left]).lerp(decode(above[right]), fx);
        let bottom = decode(below[left]).lerp(decode(below[right]), fx);
        Vec3A::from_vec4(top.lerp(bottom, fy) * (1.0 / WHITE))
    }
}

/// Four channels at once: as quick as one.
#[inline]
fn decode([r, g, b, a]: [u8; 4]) -> Vec4 {
    Vec4::new(f32::from(r), f32::from(g), f32::from(b), f32::from(a))
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
