//! An RGB image with linear filtering that repeats beyond its borders.

use evpose_core::Plane;
use glam::{Vec2, Vec3A};

/// Code value of full intensity.
const WHITE: f32 = 255.0;

/// Eight bits a channel, as every image file. Rows go downwards from v = 0.
///
/// The values are plain numbers: whether they are linear or gamma-encoded is the user's to know.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Texture {
    width: usize,
    height: usize,
    /// Red, green, blue and padding, so that a texel is one load.
    texels: Vec<[u8; 4]>,
}

impl Texture {
    /// Rounds an image in [0, 1] to eight bits.
    ///
    /// # Panics
    /// If the image is empty.
    pub fn from_plane(image: &Plane<Vec3A>) -> Self {
        assert!(!image.data().is_empty(), "a texture without texels");
        let texels = image
            .data()
            .iter()
            .map(|rgb| {
                let code = (*rgb * WHITE + 0.5).clamp(Vec3A::ZERO, Vec3A::splat(WHITE));
                [code.x as u8, code.y as u8, code.z as u8, 0]
            })
            .collect();
        Self { width: image.width(), height: image.height(), texels }
    }

    /// Takes eight-bit texels, row by row; `None` unless there are `width * height` of them.
    pub fn from_rgb8(width: usize, height: usize, rgb: &[u8]) -> Option<Self> {
        let (texels, rest) = rgb.as_chunks::<3>();
        let fits = rest.is_empty() && !texels.is_empty() && texels.len() == width * height;
        fits.then(|| Self {
            width,
            height,
            texels: texels.iter().map(|&[r, g, b]| [r, g, b, 0]).collect(),
        })
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The colour at `uv`, in [0, 1], interpolated between the centres of four texels.
    #[inline]
    pub fn sample(&self, uv: Vec2) -> Vec3A {
        let (left, right, fx) = neighbours(uv.x, self.width);
        let (above, below, fy) = neighbours(uv.y, self.height);
        let texel = |x: usize, y: usize| {
            let [r, g, b, _] = self.texels[y * self.width + x];
            Vec3A::new(f32::from(r), f32::from(g), f32::from(b))
        };
        let top = texel(left, above).lerp(texel(right, above), fx);
        let bottom = texel(left, below).lerp(texel(right, below), fx);
        top.lerp(bottom, fy) * (1.0 / WHITE)
    }
}

/// The two texels around a coordinate, and the weight of the second. The coordinate repeats with
/// period 1; texel centres lie at half-integers.
#[inline]
fn neighbours(coordinate: f32, texels: usize) -> (usize, usize, f32) {
    let position = coordinate * texels as f32 - 0.5;
    let truncated = position as i32;
    let floor = truncated - i32::from(truncated as f32 > position);
    let weight = position - floor as f32;
    let n = texels as i32;
    // Almost every sample lies inside; the division is for the others.
    let wrap = |i: i32| if (0..n).contains(&i) { i } else { i.rem_euclid(n) } as usize;
    (wrap(floor), wrap(floor.saturating_add(1)), weight)
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
        assert_eq!(Texture::from_rgb8(0, 0, &[]), None);
    }
}
