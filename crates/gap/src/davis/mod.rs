//! Frames of a camera that records both frames and events, as the scene of its events.
//!
//! ```text
//! AEDAT4 file -> Shots           frames with their exposures, those that bracket events
//!             -> LightSequence   the smoothest luminance consistent with them, a plane per millisecond
//!             -> twins           samples of other luminance consistent with such frames
//! ```
//!
//! Frames sample luminance coarsely: a few dozen per second, averaged over an exposure, quantised,
//! with a response curve that may be unknown. [`Shots::scene`] is the smoothest luminance
//! consistent with them. A [twin](Shots::twin) repeats the sampling on that luminance: the
//! differences of its summary statistics are the uncertainty due to the frames. Events are used in
//! none of it.

mod interpolation;
mod path;
mod read;
mod response;
mod twin;

use evpose_core::stats::quantile::{median_high, upper_index};
use evpose_core::{Micros, Plane, SensorSize};
use rayon::prelude::*;

pub use read::{LoadedShots, load_shots};
pub use response::{Response, UnknownResponse};

use crate::{GapError, LightSequence};
use interpolation::Interpolation;
use path::{Gate, shortest};

/// Planes per second of the interpolated luminance.
const FPS: f64 = 1_000.0;
/// Standard deviations of the noise by which the light of a code is uncertain, beyond half a step.
const NOISE_WIDTHS: f64 = 2.0;
/// Largest uncertainty (ln) of a pixel's light in any frame; other pixels are excluded.
const MAX_UNCERTAINTY: f64 = 0.15;
/// Maximum fraction of excluded pixels.
const MAX_MASKED: f64 = 0.9;
/// Variance of rounding to whole codes.
const ROUNDING: f64 = 1.0 / 12.0;
/// Minimum light, relative to white.
const DARK: f64 = 1e-5;

/// One frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// Start of the exposure, from the middle of the first frame's exposure on.
    pub start: Micros,
    /// End of the exposure.
    pub end: Micros,
    /// Codes of pixels, row by row.
    pub codes: Vec<u16>,
}

impl Shot {
    /// Middle of the exposure, microseconds.
    pub fn middle_us(&self) -> f64 {
        0.5 * (self.start.0 as f64 + self.end.0 as f64)
    }

    fn exposure_us(&self) -> f64 {
        (self.end.0 - self.start.0) as f64
    }
}

/// The frames of a part of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Shots {
    size: SensorSize,
    response: Response,
    /// Code of white, at which light saturates.
    white: u16,
    /// Standard deviation of the codes of constant light, beyond their rounding.
    noise: f64,
    /// Frames in order of time, at least two.
    shots: Vec<Shot>,
}

impl Shots {
    /// Frames of one sensor, in order of time, of codes up to `white`; the middle of the exposure
    /// of the first is time zero.
    ///
    /// # Errors
    /// Fewer than two frames, or some that are out of order or of another size.
    pub fn new(
        size: SensorSize,
        response: Response,
        white: u16,
        shots: Vec<Shot>,
    ) -> Result<Self, GapError> {
        let rises = shots.windows(2).all(|two| two[0].middle_us() < two[1].middle_us());
        let fits = shots.iter().all(|shot| shot.codes.len() == size.pixels());
        if shots.len() < 2 || !rises || !fits {
            let problem = format!("{} frames that are no sequence of {size}", shots.len());
            return Err(GapError::Scene(problem));
        }
        let mut all = Self { size, response, white, noise: 0.0, shots };
        // Needs all frames: noise is what differs between two of them where nothing moves.
        all.noise = all.noise_at_rest();
        Ok(all)
    }

    /// Size of the sensor.
    pub fn size(&self) -> SensorSize {
        self.size
    }

    /// Time from the first frame to the last.
    pub fn duration(&self) -> Micros {
        let last = self.shots.last().map_or(0.0, Shot::middle_us);
        Micros(last.round() as i64)
    }

    /// Number of planes of the scene.
    pub fn planes(&self) -> usize {
        (self.duration().as_seconds() * FPS).floor() as usize + 1
    }

    /// The smoothest luminance that is consistent with these frames.
    ///
    /// # Errors
    /// Frames that are too dark or too bright to determine the luminance.
    pub fn scene(&self) -> Result<LightSequence, GapError> {
        let fraction = self.masked_fraction();
        if fraction > MAX_MASKED {
            return Err(GapError::Scene(format!(
                "{:.0} % of the pixels of the frames are black or white, or too dark for steps of \
                 one in {}: there is no light to compare with",
                100.0 * fraction,
                self.white
            )));
        }
        Ok(self.light(Interpolation::Linear)?.with_mask(self.masked()))
    }

    fn masked_fraction(&self) -> f64 {
        let masked = self.masked();
        masked.iter().filter(|masked| **masked).count() as f64 / masked.len() as f64
    }

    /// Pixels that are saturated, or so dark that a step of the code is a large step of light, in
    /// any frame. They are excluded, because motion there would look like noise.
    fn masked(&self) -> Vec<bool> {
        let is_masked = |code: u16| {
            let [low, high] = self.limits(code, 1.0);
            code >= self.white || 0.5 * (high - low) > MAX_UNCERTAINTY
        };
        // By code once, as there are far fewer of them than pixels.
        let is_masked: Vec<bool> = (0..=self.white).map(is_masked).collect();
        let mut masked = vec![false; self.size.pixels()];
        for shot in &self.shots {
            for (masked, code) in masked.iter_mut().zip(&shot.codes) {
                *masked |= is_masked[usize::from(*code.min(&self.white))];
            }
        }
        masked
    }

    /// Lower and upper log luminance of a code, at `exposure` times the usual exposure.
    fn limits(&self, code: u16, exposure: f64) -> [f64; 2] {
        let half = 0.5 + NOISE_WIDTHS * self.noise;
        [-half, half].map(|off| {
            let light = self.response.light((f64::from(code) + off) / f64::from(self.white));
            (light / exposure).max(DARK).ln()
        })
    }

    /// Standard deviation of the codes of pixels at rest (the lower quartile of all pixels), beyond
    /// their rounding.
    fn noise_at_rest(&self) -> f64 {
        let white = f64::from(self.white);
        let exposures = self.exposures();
        // Code at the usual exposure.
        let even = |code: u16, exposure: f64| {
            white * self.response.code(self.response.light(f64::from(code) / white) / exposure)
        };
        let bends = |pixel: usize| {
            let codes = self.shots.iter().zip(&exposures).map(|(shot, e)| (shot.codes[pixel], *e));
            let codes = codes.filter(|(code, _)| (1..self.white).contains(code));
            let codes: Vec<f64> = codes.map(|(code, exposure)| even(code, exposure)).collect();
            let bends = codes.windows(3).map(|c| (c[0] - 2.0 * c[1] + c[2]).powi(2));
            // Second differences of independent codes have six times their variance.
            (codes.len() >= 3).then(|| bends.sum::<f64>() / (6.0 * (codes.len() - 2) as f64))
        };
        let mut all: Vec<f64> = (0..self.size.pixels()).filter_map(bends).collect();
        all.sort_by(f64::total_cmp);
        let quiet = all.get(upper_index(all.len(), 1, 4)).copied().unwrap_or(0.0);
        (quiet - ROUNDING).max(0.0).sqrt()
    }

    /// Exposures relative to their median, by which codes are divided.
    fn exposures(&self) -> Vec<f64> {
        let usual = self.usual_exposure_us();
        let of = |shot: &Shot| {
            if usual > 0.0 { (shot.exposure_us() / usual).max(1e-3) } else { 1.0 }
        };
        self.shots.iter().map(of).collect()
    }

    fn usual_exposure_us(&self) -> f64 {
        let mut all: Vec<f64> = self.shots.iter().map(Shot::exposure_us).collect();
        median_high(&mut all).unwrap_or(0.0)
    }

    /// Luminance on the shortest path through the limits of all frames.
    fn light(&self, interpolation: Interpolation) -> Result<LightSequence, GapError> {
        let pixels = self.size.pixels();
        let exposures = self.exposures();
        let times: Vec<f64> = self.shots.iter().map(Shot::middle_us).collect();
        // Log luminance of every frame, pixel after pixel.
        let of_shots = times.len();
        let mut logs = vec![0f32; pixels * of_shots];
        logs.par_chunks_mut(of_shots).enumerate().for_each(|(pixel, logs)| {
            let gate = |k: usize| {
                let [low, high] = self.limits(self.shots[k].codes[pixel], exposures[k]);
                Gate { t: times[k], low, high }
            };
            let gates: Vec<Gate> = (0..of_shots).map(gate).collect();
            let mut path = Vec::with_capacity(of_shots);
            shortest(&gates, &mut path);
            logs.iter_mut().zip(path).for_each(|(log, value)| *log = value as f32);
        });
        let planes = (0..self.planes()).into_par_iter().map(|k| {
            let t_us = 1e6 * k as f64 / FPS;
            let next = times.partition_point(|t| *t <= t_us).clamp(1, of_shots - 1);
            let (from, to) = (times[next - 1], times[next]);
            // Outside of the frames, light stays as in the nearest one.
            let share = ((t_us - from) / (to - from)).clamp(0.0, 1.0) as f32;
            let light = logs.chunks(of_shots).enumerate().map(|(pixel, logs)| {
                let share = interpolation.share(share, next, pixel, usize::from(self.size.width));
                (logs[next - 1] + (logs[next] - logs[next - 1]) * share).exp()
            });
            let mut plane = Plane::for_sensor(self.size, 0.0);
            plane.data_mut().iter_mut().zip(light).for_each(|(to, light)| *to = light);
            plane
        });
        LightSequence::new(FPS, planes.collect())
    }
}

#[cfg(test)]
mod tests;
