//! The frames of a camera that records both frames and events, as the scene that its events are of.
//!
//! ```text
//! AEDAT4 file -> Shots   frames with their exposures, and what of them bracket events
//!             -> Scene   the straightest light that these frames allow, a plane a millisecond
//!             -> twins   other light that frames like these allow
//! ```
//!
//! Frames are a coarse look at light: a few dozen a second, averaged over an exposure, in steps, by a
//! curve that may not be known. [`Shots::scene`] is the plainest light that gives them. A
//! [twin](Shots::twin) is that light photographed anew, worse by as much again: what the numbers of its
//! events differ by is what frames do not tell. Events have no part in any of it.

mod between;
mod path;
mod read;
mod response;
mod twin;

use evpose_core::{Micros, Plane, SensorSize};
use rayon::prelude::*;

pub use read::{LoadedShots, load_shots};
pub use response::{Response, UnknownResponse};

use crate::{GapError, Scene};
use between::Between;
use path::{Gate, shortest};

/// Planes a second of the light between frames.
const FPS: f64 = 1_000.0;
/// Light of a code is uncertain by half a step and so many standard deviations of its noise.
const NOISE_WIDTHS: f64 = 2.0;
/// A pixel whose light is less certain than this (ln) in any frame says nothing.
const LEAST_CERTAIN: f64 = 0.15;
/// So large a share of pixels may say nothing.
const MOST_BLIND: f64 = 0.9;
/// Variance of a number that is rounded.
const ROUNDING: f64 = 1.0 / 12.0;
/// The least light there is, of white.
const DARK: f64 = 1e-5;

/// One frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// When its exposure began, from the first shot's middle on.
    pub start: Micros,
    /// When its exposure ended.
    pub end: Micros,
    /// Its codes, row by row.
    pub codes: Vec<u16>,
}

impl Shot {
    /// The middle of the exposure, microseconds.
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
    /// The code of white, which is also where light is cut off.
    white: u16,
    /// Standard deviation of codes of light at rest, beyond their rounding.
    noise: f64,
    /// At least two, in order of time.
    shots: Vec<Shot>,
}

impl Shots {
    /// Frames of one sensor, in order of time, of codes up to `white`; the middle of the exposure of
    /// the first is time zero.
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
        all.noise = all.noise_at_rest();
        Ok(all)
    }

    /// The sensor.
    pub fn size(&self) -> SensorSize {
        self.size
    }

    /// From the first frame to the last.
    pub fn duration(&self) -> Micros {
        let last = self.shots.last().map_or(0.0, Shot::middle_us);
        Micros(last.round() as i64)
    }

    /// How many planes their scene has.
    pub fn planes(&self) -> usize {
        (self.duration().as_seconds() * FPS).floor() as usize + 1
    }

    /// The plainest light that gives these frames.
    ///
    /// # Errors
    /// If frames are too dark or too bright to say what light there was.
    pub fn scene(&self) -> Result<Scene, GapError> {
        let share = self.blind_share();
        if share > MOST_BLIND {
            return Err(GapError::Scene(format!(
                "{:.0} % of the pixels of the frames are black or white, or too dark for steps of \
                 one in {}: there is no light to compare with",
                100.0 * share,
                self.white
            )));
        }
        Ok(self.light(Between::Evenly)?.with_blind(self.blind()))
    }

    /// The part of the pixels that says nothing.
    fn blind_share(&self) -> f64 {
        let blind = self.blind();
        blind.iter().filter(|blind| **blind).count() as f64 / blind.len() as f64
    }

    /// Pixels that are cut off, or so dark that a step of the code is a large step of light, in any
    /// frame. What happens there is not compared: motion would look like noise.
    fn blind(&self) -> Vec<bool> {
        let is_blind = |code: u16| {
            let [low, high] = self.limits(code, 1.0);
            code >= self.white || 0.5 * (high - low) > LEAST_CERTAIN
        };
        let is_blind: Vec<bool> = (0..=self.white).map(is_blind).collect();
        let mut blind = vec![false; self.size.pixels()];
        for shot in &self.shots {
            for (blind, code) in blind.iter_mut().zip(&shot.codes) {
                *blind |= is_blind[usize::from(*code.min(&self.white))];
            }
        }
        blind
    }

    /// Between which log luminances the light of a code was, at so many times the usual exposure.
    fn limits(&self, code: u16, exposure: f64) -> [f64; 2] {
        let half = 0.5 + NOISE_WIDTHS * self.noise;
        [-half, half].map(|off| {
            let light = self.response.light((f64::from(code) + off) / f64::from(self.white));
            (light / exposure).max(DARK).ln()
        })
    }

    /// Standard deviation of the codes of pixels at rest, the quietest quarter, beyond their rounding.
    fn noise_at_rest(&self) -> f64 {
        let white = f64::from(self.white);
        let exposures = self.exposures();
        // The code that the usual exposure would have given.
        let even = |code: u16, exposure: f64| {
            white * self.response.code(self.response.light(f64::from(code) / white) / exposure)
        };
        let bends = |pixel: usize| {
            let codes = self.shots.iter().zip(&exposures).map(|(shot, e)| (shot.codes[pixel], *e));
            let codes = codes.filter(|(code, _)| (1..self.white).contains(code));
            let codes: Vec<f64> = codes.map(|(code, exposure)| even(code, exposure)).collect();
            let bends = codes.windows(3).map(|c| (c[0] - 2.0 * c[1] + c[2]).powi(2));
            // Bends of independent codes have six times their variance.
            (codes.len() >= 3).then(|| bends.sum::<f64>() / (6.0 * (codes.len() - 2) as f64))
        };
        let mut all: Vec<f64> = (0..self.size.pixels()).filter_map(bends).collect();
        all.sort_by(f64::total_cmp);
        let quiet = all.get(all.len() / 4).copied().unwrap_or(0.0);
        (quiet - ROUNDING).max(0.0).sqrt()
    }

    /// Exposures as multiples of their median: a camera that exposes longer sees no more light.
    fn exposures(&self) -> Vec<f64> {
        let usual = self.usual_exposure_us();
        let of = |shot: &Shot| {
            if usual > 0.0 { (shot.exposure_us() / usual).max(1e-3) } else { 1.0 }
        };
        self.shots.iter().map(of).collect()
    }

    fn usual_exposure_us(&self) -> f64 {
        let mut all: Vec<f64> = self.shots.iter().map(Shot::exposure_us).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    }

    fn light(&self, between: Between) -> Result<Scene, GapError> {
        let pixels = self.size.pixels();
        let exposures = self.exposures();
        let times: Vec<f64> = self.shots.iter().map(Shot::middle_us).collect();
        // Log light of every shot, pixel after pixel.
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
            let share = ((t_us - from) / (to - from)).clamp(0.0, 1.0) as f32;
            let light = logs.chunks(of_shots).enumerate().map(|(pixel, logs)| {
                let share = between.share(share, next, pixel, usize::from(self.size.width));
                (logs[next - 1] + (logs[next] - logs[next - 1]) * share).exp()
            });
            let mut plane = Plane::for_sensor(self.size, 0.0);
            plane.data_mut().iter_mut().zip(light).for_each(|(to, light)| *to = light);
            plane
        });
        Scene::new(FPS, planes.collect())
    }
}

#[cfg(test)]
mod tests;
