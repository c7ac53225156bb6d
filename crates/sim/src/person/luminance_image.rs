//! Background images of people as linear luminance, sampled bilinearly and tiled.

use std::sync::{Arc, OnceLock};

use evpose_core::{CounterRng, Plane};
use glam::{Vec2, Vec3A};

use crate::scene::luminance;
use crate::texture::{ImagePool, Texture};

/// Code value of white in an image of eight bits.
const WHITE: f32 = 255.0;

/// The images of a pool as linear luminance, each converted at its first use.
#[derive(Debug)]
pub(super) struct LuminancePool {
    pool: ImagePool,
    gamma: f32,
    planes: Vec<OnceLock<Arc<Plane<f32>>>>,
}

impl LuminancePool {
    pub(super) fn new(pool: ImagePool, gamma: f32) -> Self {
        let planes = (0..pool.len()).map(|_| OnceLock::new()).collect();
        Self { pool, gamma, planes }
    }

    pub(super) fn draw(&self, rng: &mut CounterRng) -> Arc<Plane<f32>> {
        Arc::clone(self.image(rng.below(self.planes.len())))
    }

    /// Image `index`.
    ///
    /// # Panics
    /// If `index` is out of range.
    pub(super) fn image(&self, index: usize) -> &Arc<Plane<f32>> {
        let plane = || Arc::new(linear(self.pool.image(index), self.gamma));
        self.planes[index].get_or_init(plane)
    }
}

/// Luminance of every texel, with the `gamma` encoding undone.
fn linear(image: &Texture, gamma: f32) -> Plane<f32> {
    let mut values = Plane::filled(image.width(), image.height(), 0.0);
    let (width, height) = (image.width() as f32, image.height() as f32);
    for y in 0..values.height() {
        for (x, value) in values.row_mut(y).iter_mut().enumerate() {
            let uv = Vec2::new((x as f32 + 0.5) / width, (y as f32 + 0.5) / height);
            let linear = image.sample(uv).to_array().map(|code| code.powf(gamma));
            *value = luminance(Vec3A::from_array(linear));
        }
    }
    values
}

/// Luminance as a gamma-encoded value of eight bits, as in a photograph.
pub(super) fn encoded(luminance: f32, gamma: f32) -> u8 {
    (WHITE * luminance.clamp(0.0, 1.0).powf(1.0 / gamma) + 0.5) as u8
}

/// A luminance image that tiles the plane of texture coordinates.
#[derive(Debug, Clone)]
pub(super) struct LuminanceImage {
    pub(super) values: Arc<Plane<f32>>,
    pub(super) level: f32,
}

impl LuminanceImage {
    pub(super) fn uniform(value: f32) -> Self {
        Self { values: Arc::new(Plane::filled(1, 1, value)), level: 1.0 }
    }

    /// Bilinear interpolation at `uv`, with period 1 along both coordinates.
    pub(super) fn sample(&self, uv: Vec2) -> f32 {
        let (width, height) = (self.values.width(), self.values.height());
        // Texel centres are at half-integers; one period is added so that casts truncate downwards.
        let x = (uv.x - uv.x.floor()) * width as f32 + (width as f32 - 0.5);
        let y = (uv.y - uv.y.floor()) * height as f32 + (height as f32 - 0.5);
        let (left, top) = (x as usize, y as usize);
        let (fx, fy) = (x - left as f32, y - top as f32);
        let wrap = |i: usize, n: usize| i % n;
        let (above, below) =
            (self.values.row(wrap(top, height)), self.values.row(wrap(top + 1, height)));
        let (left, right) = (wrap(left, width), wrap(left + 1, width));
        let upper = above[left] + (above[right] - above[left]) * fx;
        let lower = below[left] + (below[right] - below[left]) * fx;
        self.level * (upper + (lower - upper) * fy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_tile_and_are_interpolated() {
        let image = LuminanceImage {
            values: Arc::new(Plane::from_vec(2, 1, vec![0.0, 1.0]).expect("two texels")),
            level: 1.0,
        };
        for (u, want) in
            [(0.25, 0.0), (0.75, 1.0), (0.5, 0.5), (0.0, 0.5), (7.375, 0.25), (-0.25, 1.0)]
        {
            let got = image.sample(Vec2::new(u, 0.3));
            assert!((got - want).abs() < 1e-5, "{u}: {got}");
        }
    }
}
