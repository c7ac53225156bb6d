//! Samples of other luminance that is consistent with frames like those of a recording.

use evpose_core::{CounterRng, Plane, StageNoise, seed_for};

use super::{DARK, Interpolation, Shot, Shots};
use crate::{GapError, LightSequence};

/// Samples of the luminance during an exposure.
const EXPOSURE_SAMPLES: usize = 8;
/// Maximum offset of black from code zero, relative to white.
const BLACK: f32 = 0.004;
/// Minimum duration of a change of luminance, as a fraction of the time between two frames.
const SHORTEST: f32 = 0.02;

impl Shots {
    /// Draws twin `i` of the luminance of these frames. The scene is exposed again at every second
    /// frame, with another rounding, another black and the same noise; from one of these to the
    /// next, luminance changes abruptly, as edges that pass by do.
    ///
    /// The losses of frames are thus applied twice, and what they do not determine at all, the time
    /// of a change between two of them, is drawn at random.
    ///
    /// # Errors
    /// Those of [`Shots::scene`].
    pub fn twin(&self, i: u64, seed: u64) -> Result<LightSequence, GapError> {
        let scene = self.scene()?;
        let mut rng = CounterRng::new(seed, "twin", i);
        let black = rng.uniform(-BLACK, BLACK) * f32::from(self.white);
        let share = SHORTEST.powf(rng.unit());
        let slant = [rng.uniform(-0.05, 0.05), rng.uniform(-0.05, 0.05)];
        // Edges along columns, along rows, oblique, and light that changes everywhere at once.
        let is_along =
            [i % 4 < 2, i.is_multiple_of(2)].map(|is_along| if is_along { 1.0 } else { 0.0 });
        let wave = [slant[0] * is_along[0], slant[1] * is_along[1], rng.unit()];
        let exposures = self.exposures();
        let last = self.shots.len() - 1;
        // The ends always, or a twin would be shorter than the recording.
        let is_used = |k: &usize| *k == 0 || *k == last || *k as u64 % 2 == i % 2;
        let place = StageNoise::new(seed_for(seed, "rounding", i), "twin", 0);
        let noise = |k: usize| StageNoise::new(seed_for(seed, "frame", i), "twin", k as u64);
        let shot = |k: usize| {
            let shot = &self.shots[k];
            let light = exposed(&scene, shot);
            let noise = noise(k);
            let code = |(pixel, light): (usize, &f32)| {
                let exact = self.response.code(f64::from(*light) * exposures[k]) as f32;
                // The same in all frames, since black and rounding of a pixel do not flicker.
                let off = black + place.uniform(pixel, 0) - 0.5;
                let value = exact * f32::from(self.white)
                    + off
                    + self.noise as f32 * noise.normal(pixel, 0);
                value.round().clamp(0.0, f32::from(self.white)) as u16
            };
            let codes = light.data().iter().enumerate().map(code).collect();
            Shot { codes, ..*shot }
        };
        let shots = (0..=last).filter(is_used).map(shot).collect();
        let twin = Self { shots, ..*self };
        let light = twin.light(Interpolation::Edge { share, wave })?;
        Ok(light.with_mask(scene.masked().to_vec()))
    }
}

/// Mean luminance during an exposure.
fn exposed(scene: &LightSequence, shot: &Shot) -> Plane<f32> {
    let planes = scene.planes();
    let (width, height) = (planes[0].width(), planes[0].height());
    let mut mean = Plane::filled(width, height, 0.0);
    let lasts_us = (shot.end - shot.start).0 as f64;
    // The shutter integrates: a mean over its time blurs motion as the camera's frames do.
    for sample in 0..EXPOSURE_SAMPLES {
        let t = shot.start.0 as f64 + lasts_us * (sample as f64 + 0.5) / EXPOSURE_SAMPLES as f64;
        let place = (t * 1e-6 * scene.fps()).clamp(0.0, (planes.len() - 1) as f64);
        let k = (place as usize).min(planes.len() - 2);
        let share = (place - k as f64) as f32;
        let both = planes[k].data().iter().zip(planes[k + 1].data());
        for (mean, (a, b)) in mean.data_mut().iter_mut().zip(both) {
            *mean += (a + (b - a) * share).max(DARK as f32) / EXPOSURE_SAMPLES as f32;
        }
    }
    mean
}
