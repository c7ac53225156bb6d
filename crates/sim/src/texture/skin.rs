//! Procedural skin from eight coefficients, for the texture layout of the procedural arm.
//!
//! The image is albedo, taken as linear like the published textures. Across the image (u) lies the
//! limb from shoulder to fingertips, downwards (v) the way from its back to the palm.

use std::f32::consts::TAU;

use evpose_body::texture_layout::{
    U_END_JOINT, U_KNUCKLE, U_MIDDLE_JOINT, U_NAIL, U_TIP, U_WRIST, V_NAIL,
};
use evpose_core::{CounterRng, Plane};
use glam::Vec3A;

use super::Texture;
use super::noise::{fractal_noise, smoothstep};

/// Coefficients of a person's skin. Each is drawn from N(0, sd²), as are the 101 coefficients of
/// the published texture space; zero is the average.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SkinCoefficients {
    /// Darker with more of it.
    pub melanin: f32,
    /// Redder with more of it.
    pub blood: f32,
    /// Contrast between palm and back.
    pub palm: f32,
    /// Unevenness of the tone.
    pub mottling: f32,
    /// Veins on the back of hand and forearm.
    pub veins: f32,
    /// Depth of creases and lines.
    pub creases: f32,
    /// Freckles on the back.
    pub freckles: f32,
    /// Brightness of the nails.
    pub nails: f32,
}

impl SkinCoefficients {
    /// Draws the coefficients of a person.
    pub fn draw(rng: &mut CounterRng, sd: f32) -> Self {
        let mut normal = || sd * rng.normal();
        Self {
            melanin: normal(),
            blood: normal(),
            palm: normal(),
            mottling: normal(),
            veins: normal(),
            creases: normal(),
            freckles: normal(),
            nails: normal(),
        }
    }
}

/// Albedo of average skin on the back of the hand, chosen by eye.
const AVERAGE: Vec3A = Vec3A::new(0.72, 0.52, 0.42);
/// Optical density per channel of one unit of melanin: absorption rises towards blue.
const MELANIN: Vec3A = Vec3A::new(0.13, 0.20, 0.25);
/// Optical density per channel of one unit of blood: haemoglobin absorbs green most.
const BLOOD: Vec3A = Vec3A::new(0.0, 0.06, 0.04);

/// Paints the skin of a person; `rng` places its marks.
///
/// # Panics
/// If `size` is zero.
pub fn paint_skin(size: usize, coefficients: &SkinCoefficients, rng: &mut CounterRng) -> Texture {
    Texture::from_plane(&skin_albedo(size, coefficients, rng))
}

/// The albedo of [`paint_skin`].
pub(super) fn skin_albedo(
    size: usize,
    coefficients: &SkinCoefficients,
    rng: &mut CounterRng,
) -> Plane<Vec3A> {
    assert!(size > 0, "skin of size zero");
    // A factor around 1 for each strength: two units are a factor of 1.6.
    let [mottling, veins, creases, freckles, palm] = [
        coefficients.mottling,
        coefficients.veins,
        coefficients.creases,
        coefficients.freckles,
        coefficients.palm,
    ]
    .map(|c| (0.25 * c).clamp(-1.5, 1.5).exp());
    // Texels are longer along the limb than around it: more cells along than around are round.
    let mut noise =
        |cells: (usize, usize), octaves| fractal_noise((size, size), cells, octaves, 0.6, rng);
    let tone = noise((12, 4), 4);
    let vein = noise((24, 5), 2);
    let grain = noise((size / 2, size / 4), 1);
    let spots = noise((size / 6, size / 10), 1);
    let bend = noise((8, 8), 3);
    let nail = nail_colour(coefficients);
    let mut image = Plane::filled(size, size, Vec3A::ZERO);
    for y in 0..size {
        let v = (y as f32 + 0.5) / size as f32;
        let palmar = smoothstep((v - 0.4) / 0.3);
        for x in 0..size {
            let u = (x as f32 + 0.5) / size as f32;
            let bent = u + 0.006 * bend.at(x, y);
            // Densities add up, and light falls as exp(-d), after Beer and Lambert.
            let mut density = MELANIN * (coefficients.melanin * (1.0 - 0.5 * palmar))
                + BLOOD * (coefficients.blood + 1.5 * palm * palmar);
            density -= Vec3A::splat(0.10 * palm * palmar);
            density += Vec3A::new(0.18, 0.26, 0.24) * (mottling * tone.at(x, y));
            density += Vec3A::splat(0.06 * grain.at(x, y));
            let freckle = smoothstep((*spots.at(x, y) - 0.62) / 0.2) * (1.0 - palmar);
            density += MELANIN * (0.9 * freckles * freckle);
            density += VEIN * (veins * vein_at(u, v, *vein.at(x, y)));
            density += CREASE * (creases * crease_at(bent, v));
            let skin = AVERAGE * Vec3A::from_array(density.to_array().map(|d| (-d).exp()));
            // Nails lie over the skin, in a colour of their own.
            let (cover, lunula) = nail_at(u, v);
            let colour = skin.lerp(nail.lerp(Vec3A::splat(0.92), lunula), cover);
            *image.at_mut(x, y) = colour.clamp(Vec3A::ZERO, Vec3A::ONE);
        }
    }
    image
}

/// Density of a vein under the skin: less red comes back than blue.
const VEIN: Vec3A = Vec3A::new(0.35, 0.2, 0.1);
/// Density at the bottom of a crease.
const CREASE: Vec3A = Vec3A::new(0.45, 0.6, 0.6);

/// Veins run where a smooth field crosses zero, on the back between elbow and knuckles.
fn vein_at(u: f32, v: f32, field: f32) -> f32 {
    let along = smoothstep((u - 0.2) / 0.1) * (1.0 - smoothstep((u - U_KNUCKLE) / 0.06));
    let back = 1.0 - smoothstep((v - 0.35) / 0.2);
    along * back * (-(field / 0.05).powi(2)).exp()
}

/// A dark line of half-width `half_width` at distance `distance`.
fn line(distance: f32, half_width: f32) -> f32 {
    (1.0 - (distance / half_width).powi(2)).max(0.0)
}

/// Creases across the joints, wrinkles over the knuckles, the lines of palm and wrist.
fn crease_at(u: f32, v: f32) -> f32 {
    let mut depth: f32 = 0.0;
    let palmar = smoothstep((v - 0.5) / 0.2);
    let back = 1.0 - smoothstep((v - 0.3) / 0.2);
    for (joint, width, folds) in
        [(U_KNUCKLE, 0.012, 0.25), (U_MIDDLE_JOINT, 0.010, 0.7), (U_END_JOINT, 0.008, 0.7)]
    {
        let distance = (u - joint).abs();
        if distance < 0.05 {
            depth = depth.max(palmar * line(distance, 0.4 * width));
            depth = depth.max(0.5 * palmar * line(distance - 1.3 * width, 0.3 * width));
            // Stretched skin folds into several fine wrinkles, deepest at the joint.
            let fold = 0.5 + 0.5 * (TAU * distance / width).cos();
            depth = depth.max(folds * back * fold.powi(3) * (1.0 - distance / 0.05).powi(2));
        }
    }
    if (U_WRIST - 0.03..U_KNUCKLE).contains(&u) {
        let across = v - 0.75;
        for wrist in [U_WRIST - 0.012, U_WRIST + 0.004] {
            depth = depth.max(0.6 * palmar * line(u - wrist, 0.004));
        }
        // Heart, head and life line, from the side of the palm towards its middle.
        for (start, slope, curve) in [(0.55, 0.06, -0.3), (0.50, 0.02, -0.9), (0.45, -0.25, 0.4)] {
            let course = start + slope * across + curve * across * across;
            depth = depth.max(0.9 * smoothstep((v - 0.65) / 0.1) * line(u - course, 0.004));
        }
    }
    depth
}

/// Coverage by the nail, and by its pale root or edge.
fn nail_at(u: f32, v: f32) -> (f32, f32) {
    let [root, edge] = U_NAIL;
    if u < root - 0.01 || v > V_NAIL {
        return (0.0, 0.0);
    }
    let side = 1.0 - smoothstep((v - 0.85 * V_NAIL) / (0.15 * V_NAIL));
    // The root is round: it begins later towards the sides.
    let start = root + 0.25 * (edge - root) * (v / V_NAIL).powi(2);
    let cover = side * smoothstep((u - start + 0.003) / 0.006);
    let lunula = 1.0 - smoothstep((u - start - 0.012) / 0.006);
    let free_edge = smoothstep((u - edge + 0.01) / 0.005) * (1.0 - smoothstep((u - U_TIP) / 0.01));
    (cover, 0.6 * lunula.max(free_edge))
}

fn nail_colour(coefficients: &SkinCoefficients) -> Vec3A {
    Vec3A::new(0.88, 0.66, 0.60) * (0.05 * coefficients.nails).clamp(-0.3, 0.12).exp()
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::scene::luminance;

    fn mean(texture: &Texture) -> f32 {
        let n = 64;
        let at = |i: usize| (i as f32 + 0.5) / n as f32;
        let samples = (0..n * n).map(|i| Vec2::new(at(i % n), at(i / n)));
        samples.map(|uv| luminance(texture.sample(uv))).sum::<f32>() / (n * n) as f32
    }

    #[test]
    fn melanin_darkens_and_the_average_is_between() {
        let person = |melanin| SkinCoefficients { melanin, ..SkinCoefficients::default() };
        let tone =
            |melanin| mean(&paint_skin(64, &person(melanin), &mut CounterRng::new(1, "skin", 0)));
        let (pale, average, dark) = (tone(-2.0), tone(0.0), tone(4.0));
        assert!(pale > average && average > dark, "{pale} {average} {dark}");
        assert!((0.4..0.7).contains(&average), "{average}");
    }

    #[test]
    fn nails_are_paler_than_the_skin_around_and_creases_darker() {
        let skin =
            paint_skin(512, &SkinCoefficients::default(), &mut CounterRng::new(1, "skin", 0));
        let at = |u: f32, v: f32| luminance(skin.sample(Vec2::new(u, v)));
        assert!(at(0.96, 0.1) > 1.05 * at(0.90, 0.1));
        let darkest = (0..40).map(|i| at(0.73 + 0.001 * i as f32, 0.9)).fold(1.0, f32::min);
        assert!(darkest < 0.75 * at(0.70, 0.9), "{darkest}");
    }
}
