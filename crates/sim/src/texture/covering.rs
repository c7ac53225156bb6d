//! Sleeves, gloves, rings and watches, painted over the skin of the procedural arm.

use std::f32::consts::TAU;

use evpose_body::texture_layout::{U_KNUCKLE, U_MIDDLE_JOINT, U_TIP, U_WRIST};
use evpose_core::{CounterRng, Plane};
use glam::Vec3A;

use super::canvas::random_colour;
use super::noise::fractal_noise;
use crate::config::SkinConfig;

#[derive(Debug, Clone, Copy)]
struct Band {
    /// Both ends, along the limb.
    u: [f32; 2],
    first: Vec3A,
    second: Vec3A,
    /// Stripes across the band; none for a plain one.
    stripes: f32,
}

impl Band {
    fn draw(rng: &mut CounterRng, u: [f32; 2]) -> Self {
        Self {
            u,
            first: random_colour(rng, (0.0, 0.7), (0.03, 0.9)),
            second: random_colour(rng, (0.0, 0.7), (0.03, 0.9)),
            stripes: if rng.chance(0.3) { rng.uniform(10.0, 60.0) } else { 0.0 },
        }
    }

    fn colour(&self, u: f32, noise: f32) -> Vec3A {
        let is_second = self.stripes > 0.0 && (TAU * self.stripes * u).sin() > 0.0;
        (if is_second { self.second } else { self.first }) * (1.0 + 0.4 * noise)
    }
}

/// Paints the coverings of an episode's hand over its skin.
pub(super) fn paint_covering(config: &SkinConfig, skin: &mut Plane<Vec3A>, rng: &mut CounterRng) {
    let mut bands = Vec::new();
    if rng.chance(config.sleeves) {
        // From above the wrist to over the root of the thumb.
        let end = rng.uniform(U_WRIST - 0.12, U_WRIST + 0.06);
        bands.push(Band::draw(rng, [0.0, end]));
    } else if rng.chance(config.rings) {
        // A watch, where no sleeve covers the wrist.
        let at = U_WRIST - 0.03;
        let end = at + rng.uniform(0.01, 0.035);
        bands.push(Band::draw(rng, [at, end]));
    }
    if rng.chance(config.gloves) {
        let end = if rng.chance(0.3) { U_MIDDLE_JOINT } else { U_TIP + 0.1 };
        bands.push(Band::draw(rng, [U_WRIST - 0.02, end]));
    } else if rng.chance(config.rings) {
        // A ring, where no glove covers the finger.
        let at = U_KNUCKLE + 0.06;
        bands.push(Band::draw(rng, [at, at + 0.012]));
    }
    if bands.is_empty() {
        return;
    }
    let (width, height) = (skin.width(), skin.height());
    let folds = fractal_noise((width, height), (20, 6), 3, 0.6, rng);
    for y in 0..height {
        for x in 0..width {
            let u = (x as f32 + 0.5) / width as f32;
            // Later bands cover earlier ones: a glove goes over a cuff.
            for band in bands.iter().filter(|band| (band.u[0]..band.u[1]).contains(&u)) {
                let colour = band.colour(u, *folds.at(x, y));
                *skin.at_mut(x, y) = colour.clamp(Vec3A::ZERO, Vec3A::ONE);
            }
        }
    }
}
