//! Other light that gives frames like the ones there are.

use evpose_core::{CounterRng, Plane, StageNoise, seed_for};

use super::{Between, DARK, Shot, Shots};
use crate::{GapError, Scene};

/// Looks at the light during an exposure.
const LOOKS: usize = 8;
/// Black is this far from code zero at most, of white.
const BLACK: f32 = 0.004;
/// Of the time between two frames, light takes this part at least to change.
const SHORTEST: f32 = 0.02;

impl Shots {
    /// Twin number `i` of the light of these frames: it is photographed with every second
    /// frame, whose codes are rounded in another place, of another black, and as noisy. From one of
    /// these to the next, light changes in a part of the time, as edges do that pass by.
    ///
    /// What frames like these do to the light that they show is thus done twice, and what they cannot
    /// show at all, when between two of them light changed, is made up.
    ///
    /// # Errors
    /// As [`Shots::scene`].
    pub fn twin(&self, i: u64, seed: u64) -> Result<Scene, GapError> {
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
        let is_kept = |k: &usize| *k == 0 || *k == last || *k as u64 % 2 == i % 2;
        let place = StageNoise::new(seed_for(seed, "rounding", i), "twin", 0);
        let noise = |k: usize| StageNoise::new(seed_for(seed, "frame", i), "twin", k as u64);
        let shot = |k: usize| {
            let shot = &self.shots[k];
            let light = exposed(&scene, shot);
            let noise = noise(k);
            let code = |(pixel, light): (usize, &f32)| {
                let exact = self.response.code(f64::from(*light) * exposures[k]) as f32;
                let off = black + place.uniform(pixel, 0) - 0.5;
                let seen = exact * f32::from(self.white)
                    + off
                    + self.noise as f32 * noise.normal(pixel, 0);
                seen.round().clamp(0.0, f32::from(self.white)) as u16
            };
            let codes = light.data().iter().enumerate().map(code).collect();
            Shot { codes, ..*shot }
        };
        let shots = (0..=last).filter(is_kept).map(shot).collect();
        let twin = Self { shots, ..*self };
        let light = twin.light(Between::Abruptly { share, wave })?;
        Ok(light.with_blind(scene.blind().to_vec()))
    }
}

/// The mean light during an exposure.
fn exposed(scene: &Scene, shot: &Shot) -> Plane<f32> {
    let planes = scene.planes();
    let (width, height) = (planes[0].width(), planes[0].height());
    let mut mean = Plane::filled(width, height, 0.0);
    let lasts_us = (shot.end - shot.start).0 as f64;
    for look in 0..LOOKS {
        let t = shot.start.0 as f64 + lasts_us * (look as f64 + 0.5) / LOOKS as f64;
        let place = (t * 1e-6 * scene.fps()).clamp(0.0, (planes.len() - 1) as f64);
        let k = (place as usize).min(planes.len() - 2);
        let share = (place - k as f64) as f32;
        let both = planes[k].data().iter().zip(planes[k + 1].data());
        for (mean, (a, b)) in mean.data_mut().iter_mut().zip(both) {
            *mean += (a + (b - a) * share).max(DARK as f32) / LOOKS as f32;
        }
    }
    mean
}
