//! Distractors: textured rectangles and ellipses that oscillate before the background plane.

use evpose_core::CounterRng;
use glam::Vec2;

use super::background_plane::PlaneView;
use super::luminance_image::{LuminanceImage, LuminancePool};

// The ranges below were chosen by eye: distractors as large as a limb or a torso, that cross the
// view at the speed of walking and gesturing. Lengths are shares of the visible part of the plane.

/// Luminance relative to the background.
const LEVEL: [f32; 2] = [0.4, 1.2];
/// Mean position relative to the centre of the view, across and up.
const OFFSET: [[f32; 2]; 2] = [[-0.5, 0.5], [-0.4, 0.4]];
/// Amplitude of the oscillation, across and up: mostly sideways, as of passers-by.
const AMPLITUDE: [[f32; 2]; 2] = [[0.05, 0.45], [0.0, 0.12]];
/// Angular frequency of the oscillation in rad/s, across and up.
const RATE: [[f32; 2]; 2] = [[0.5, 2.5], [0.5, 4.0]];
/// Phase of the oscillation in radians: about one period.
const PHASE: [f32; 2] = [0.0, 6.3];
/// Half of the extent, across and up.
const HALF_EXTENT: [[f32; 2]; 2] = [[0.03, 0.13], [0.04, 0.2]];
/// Share of its image that a distractor shows along each coordinate.
const CROP: [f32; 2] = [0.2, 0.6];

/// Probability that an object before people does not move, as furniture.
const AT_REST: f32 = 0.6;

#[derive(Debug, Clone)]
pub(super) struct Distractor {
    image: LuminanceImage,
    /// Mean position of the centre on the plane, in metres.
    mean_m: Vec2,
    /// Amplitudes of the sinusoidal motion of the centre, in metres.
    amplitude_m: Vec2,
    /// Angular frequencies in rad/s.
    rates: Vec2,
    /// Phases in radians.
    phases: Vec2,
    /// Half of the extent along both axes, in metres.
    half_m: Vec2,
    is_ellipse: bool,
    /// Share of the image that is shown.
    crop: f32,
}

impl Distractor {
    /// Draws a distractor for a plane; `view` is its visible part, `level` multiplies its luminance.
    pub(super) fn draw(
        rng: &mut CounterRng,
        images: &LuminancePool,
        view: &PlaneView,
        level: f32,
    ) -> Self {
        let extent = view.extent_m;
        let uniform = |rng: &mut CounterRng, [low, high]: [f32; 2]| rng.uniform(low, high);
        let across_and_up = |rng: &mut CounterRng, [x, y]: [[f32; 2]; 2]| {
            Vec2::new(uniform(rng, x), uniform(rng, y))
        };
        // The order of the fields is the order of the draws, which recorded sequences depend on.
        Self {
            image: LuminanceImage { values: images.draw(rng), level: level * uniform(rng, LEVEL) },
            mean_m: view.centre_m + extent * across_and_up(rng, OFFSET),
            amplitude_m: extent * across_and_up(rng, AMPLITUDE),
            rates: across_and_up(rng, RATE),
            phases: across_and_up(rng, [PHASE, PHASE]),
            half_m: extent * across_and_up(rng, HALF_EXTENT),
            is_ellipse: rng.chance(0.5),
            crop: uniform(rng, CROP),
        }
    }

    /// The same, at rest with a probability of [`AT_REST`].
    pub(super) fn at_rest_or_not(self, rng: &mut CounterRng) -> Self {
        let amplitude_m = if rng.chance(AT_REST) { Vec2::ZERO } else { self.amplitude_m };
        Self { amplitude_m, ..self }
    }

    /// Centre on the plane at time `t_s`, in metres.
    pub(super) fn centre_m(&self, t_s: f32) -> Vec2 {
        let angle = self.rates * t_s + self.phases;
        self.mean_m + self.amplitude_m * Vec2::new(angle.x.sin(), angle.y.sin())
    }

    /// Corners of the bounding rectangle around `centre_m`, in metres.
    pub(super) fn corners_m(&self, centre_m: Vec2) -> [Vec2; 4] {
        [Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0), Vec2::new(-1.0, 1.0), Vec2::ONE]
            .map(|corner| centre_m + corner * self.half_m)
    }

    /// Luminance at `point_m` of the plane, if the distractor covers it.
    pub(super) fn sample(&self, point_m: Vec2, centre_m: Vec2) -> Option<f32> {
        let local = (point_m - centre_m) / self.half_m;
        let is_covered = if self.is_ellipse {
            local.length_squared() <= 1.0
        } else {
            local.abs().max_element() <= 1.0
        };
        is_covered.then(|| self.image.sample(0.5 * local * self.crop + 0.5))
    }
}
