//! A Kalman filter whose values move at constant velocity, each independent of the others.
//!
//! # Model
//! Per value, the state is position and velocity. Between measurements `dt` apart:
//!
//! ```text
//!   F = [1 dt]      Q = σ² · [dt⁴/4  dt³/2]      predict  x = F x,  P = F P Fᵀ + Q
//!       [0  1]               [dt³/2  dt²  ]
//!   H = [1  0],  S = P₁₁ + R,  K = (P₁₁, P₁₂)/S  update   x += K (z − x₁)
//!                                                         P = (I − KH) P (I − KH)ᵀ + K R Kᵀ
//! ```
//!
//! The update of `P` is Joseph's, which stays positive under rounding. `P` does not depend on the
//! measurements, so all values of the same noise share one.
//!
//! The filter starts with `P = diag(R, √(σ²R))`: a position as uncertain as one measurement, and a
//! velocity that crosses this uncertainty within the filter's own time constant. The published
//! program starts with `P = I`.
//!
//! # Source
//! EventHands supplement, Eq. 4 to 6. What the default changes, and why: [`super::KalmanConfig`].

use std::ops::Range;

use evpose_core::Micros;

use super::config::PUBLISHED_STEP_S;
use super::{InitialState, KalmanConfig, NoiseVariances, TimeStep};
use crate::{PARAMETERS, PoseError};

/// Position and velocity of one value.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Track {
    pub(super) position: f64,
    pub(super) velocity: f64,
}

/// The symmetric 2x2 covariance of a track.
#[derive(Debug, Clone, Copy)]
struct Covariance {
    position: f64,
    cross: f64,
    velocity: f64,
}

impl Covariance {
    fn initial(noise: NoiseVariances, time_step: TimeStep) -> Self {
        let [position, velocity] = match time_step {
            TimeStep::Elapsed => {
                [noise.measurement, (noise.acceleration * noise.measurement).sqrt()]
            }
            TimeStep::PublishedFrame => [1.0, 1.0],
        };
        Self { position, cross: 0.0, velocity }
    }

    /// `F P Fᵀ + Q` for a motion over `step` and a noise over `noise_step`.
    fn predicted(self, step: f64, noise_step: f64, acceleration_variance: f64) -> Self {
        let (h, s) = (noise_step, acceleration_variance);
        Self {
            position: self.position
                + step * (2.0 * self.cross + step * self.velocity)
                + s * h.powi(4) / 4.0,
            cross: self.cross + step * self.velocity + s * h.powi(3) / 2.0,
            velocity: self.velocity + s * h * h,
        }
    }

    /// Gain on position and velocity, and the covariance after a measurement of variance `r`.
    fn updated(self, r: f64) -> ([f64; 2], Self) {
        let innovation = self.position + r;
        let [k, l] = [self.position / innovation, self.cross / innovation];
        let rest = 1.0 - k;
        let after = Self {
            position: rest * rest * self.position + r * k * k,
            cross: rest * (self.cross - l * self.position) + r * k * l,
            velocity: self.velocity - 2.0 * l * self.cross + l * l * (self.position + r),
        };
        ([k, l], after)
    }
}

/// Consecutive values of the same noise.
#[derive(Debug, Clone)]
struct Group {
    values: Range<usize>,
    noise: NoiseVariances,
    covariance: Covariance,
}

/// The groups of `values` values; those of a hand have three.
fn groups_of(config: &KalmanConfig, values: usize) -> Vec<Group> {
    let same = NoiseVariances {
        acceleration: config.acceleration_variance,
        measurement: config.measurement_variance,
    };
    // The three parts are those of a hand; any other values share one noise.
    let parts = match config.hand {
        Some(noise) if values == PARAMETERS => noise.parts().to_vec(),
        _ => vec![(values, same)],
    };
    let mut start = 0;
    let group = |(count, noise): (usize, NoiseVariances)| {
        let values = start..start + count;
        start += count;
        Group { values, noise, covariance: Covariance::initial(noise, config.time_step) }
    };
    parts.into_iter().map(group).collect()
}

/// A constant-velocity Kalman filter over a vector of independent values.
///
/// Time that runs backwards means that the stream started again, and so does the filter.
#[derive(Debug, Clone)]
pub struct ConstantVelocityKalman {
    config: KalmanConfig,
    tracks: Vec<Track>,
    groups: Vec<Group>,
    /// Time of the last measurement, once there was one.
    last: Option<Micros>,
    largest_innovation: f64,
}

impl ConstantVelocityKalman {
    /// A filter over `values` independent values.
    ///
    /// # Errors
    /// If a variance is not positive and finite.
    pub fn new(config: KalmanConfig, values: usize) -> Result<Self, PoseError> {
        config.validate()?;
        let groups = groups_of(&config, values);
        let tracks = vec![Track::default(); values];
        Ok(Self { config, tracks, groups, last: None, largest_innovation: 0.0 })
    }

    /// Takes the measurement `z` of time `t` and writes the estimate for the same time to `out`.
    ///
    /// A measurement that is not finite counts as missing: the estimate is then the prediction, or
    /// the measurement itself where there was none before.
    ///
    /// # Panics
    /// If `z` or `out` has another length than the filter was made for.
    pub fn update(&mut self, t: Micros, z: &[f32], out: &mut [f32]) {
        assert_eq!(z.len(), self.tracks.len(), "the filter was made for another length");
        assert_eq!(out.len(), self.tracks.len(), "the filter was made for another length");
        // A measurement is taken whole or not at all.
        let measured = z.iter().all(|v| v.is_finite());
        self.largest_innovation = 0.0;
        // Time goes back: another recording has begun.
        if self.last.is_some_and(|last| t < last) {
            self.reset();
        }
        let Some(last) = self.last else {
            // Without a state there is nothing to filter.
            out.copy_from_slice(z);
            if measured {
                self.start(t, z, out);
                self.last = Some(t);
            }
            return;
        };
        // Without a measurement the prediction stands.
        self.predict(last, t);
        if measured {
            self.correct(z);
        }
        self.last = Some(t);
        self.write(out);
    }

    /// Forgets every measurement.
    pub fn reset(&mut self) {
        self.tracks.fill(Track::default());
        self.groups = groups_of(&self.config, self.tracks.len());
        self.last = None;
        self.largest_innovation = 0.0;
    }

    /// The estimated values, in full precision.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.tracks.iter().map(|track| track.position)
    }

    /// Their velocities, in units per second; per frame with [`TimeStep::PublishedFrame`].
    pub fn velocities(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.tracks.iter().map(|track| track.velocity)
    }

    /// How far the last measurement was from its prediction, in the value where it was furthest;
    /// 0 where there was nothing to predict from, and for a missing measurement.
    pub fn largest_innovation(&self) -> f64 {
        self.largest_innovation
    }

    /// Goes on with other settings, which must be valid; the state stays, and the covariance of
    /// groups that both settings have.
    pub fn retune(&mut self, config: KalmanConfig) {
        self.config = config;
        let mut groups = groups_of(&config, self.tracks.len());
        for (new, old) in groups.iter_mut().zip(&self.groups) {
            if new.values == old.values {
                new.covariance = old.covariance;
            }
        }
        self.groups = groups;
    }

    pub(super) fn tracks_mut(&mut self) -> &mut [Track] {
        &mut self.tracks
    }

    /// Moves the state to time `t`.
    fn predict(&mut self, last: Micros, t: Micros) {
        let (step, noise_step) = match self.config.time_step {
            TimeStep::Elapsed => ((t - last).as_seconds(), (t - last).as_seconds()),
            TimeStep::PublishedFrame => (1.0, PUBLISHED_STEP_S),
        };
        for track in &mut self.tracks {
            track.position += step * track.velocity;
        }
        for group in &mut self.groups {
            group.covariance =
                group.covariance.predicted(step, noise_step, group.noise.acceleration);
        }
    }

    /// Corrects the state by a measurement.
    fn correct(&mut self, z: &[f32]) {
        for group in &mut self.groups {
            // The gain depends on the noise alone, so that one serves all values of a group.
            let ([k, l], covariance) = group.covariance.updated(group.noise.measurement);
            group.covariance = covariance;
            let values = group.values.clone();
            for (track, &z) in self.tracks[values.clone()].iter_mut().zip(&z[values]) {
                let innovation = f64::from(z) - track.position;
                self.largest_innovation = self.largest_innovation.max(innovation.abs());
                track.position += k * innovation;
                track.velocity += l * innovation;
            }
        }
    }

    /// Begins with the first measurement, which `out` already holds.
    fn start(&mut self, t: Micros, z: &[f32], out: &mut [f32]) {
        let value = |i: usize| z.get(i).copied().map_or(0.0, f64::from);
        match self.config.initial_state {
            InitialState::FirstMeasurement => {
                for (i, track) in self.tracks.iter_mut().enumerate() {
                    *track = Track { position: value(i), velocity: 0.0 };
                }
            }
            InitialState::Concatenated => {
                // As published: measurements are taken for positions and velocities in turn.
                for (i, track) in self.tracks.iter_mut().enumerate() {
                    *track = Track { position: value(2 * i), velocity: value(2 * i + 1) };
                }
            }
            InitialState::Zero => {
                // From zero, the first measurement is a correction like all others.
                self.predict(t, t);
                self.correct(z);
                self.write(out);
            }
        }
    }

    fn write(&self, out: &mut [f32]) {
        for (out, track) in out.iter_mut().zip(&self.tracks) {
            *out = track.position as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::NoiseSetting;
    use super::*;

    const MS: Micros = Micros::MILLISECOND;

    fn filter(config: KalmanConfig, values: usize) -> ConstantVelocityKalman {
        ConstantVelocityKalman::new(config, values).expect("valid settings")
    }

    #[test]
    fn a_constant_stays_constant() {
        let mut kalman = filter(KalmanConfig::default(), 2);
        let mut out = [0.0; 2];
        for k in 0..500 {
            kalman.update(Micros(k * 1_000), &[0.5, -1.25], &mut out);
            assert_eq!(out, [0.5, -1.25]);
        }
    }

    #[test]
    fn a_straight_motion_is_followed_without_lag() {
        let mut kalman = filter(KalmanConfig::default(), 1);
        let (velocity, mut out) = (0.7, [0.0]);
        for k in 0..3_000 {
            let t = Micros(k * 1_000);
            kalman.update(t, &[(velocity * t.as_seconds()) as f32], &mut out);
        }
        assert!((f64::from(out[0]) - velocity * 2.999).abs() < 1e-5, "{out:?}");
        let estimated = kalman.velocities().next().expect("one value");
        assert!((estimated - velocity).abs() < 1e-4, "{estimated}");
    }

    /// Kalata's closed form, over three orders of magnitude of the step.
    #[test]
    fn the_steady_gain_is_that_of_the_tracking_index() {
        let config = KalmanConfig::default();
        for dt_us in [100, 1_000, 10_000, 100_000] {
            let dt_s = Micros(dt_us).as_seconds();
            let lambda2 = config.acceleration_variance * dt_s.powi(4) / config.measurement_variance;
            let lambda = lambda2.sqrt();
            let root = (lambda2 + 8.0 * lambda).sqrt();
            let alpha = ((lambda + 4.0) * root - lambda2 - 8.0 * lambda) / 8.0;
            let mut kalman = filter(config, 1);
            let mut t = Micros(0);
            // Even at 0.1 ms a step, these are 2 s and many time constants.
            for _ in 0..20_000 {
                kalman.update(t, &[0.0], &mut [0.0]);
                t = t + Micros(dt_us);
            }
            let before = kalman.positions().next().expect("one value");
            kalman.update(t, &[1.0], &mut [0.0]);
            let gain = kalman.positions().next().expect("one value") - before;
            assert!((gain - alpha).abs() < 1e-9, "{dt_us} µs: {gain}, not {alpha}");
        }
    }

    /// A sine at the cutoff loses 3 dB at any rate of measurements, and parity at 1 kHz as well.
    #[test]
    fn the_cutoff_is_where_a_sine_loses_three_decibels() {
        let config = KalmanConfig::default();
        let parity = KalmanConfig::parity(NoiseSetting::Regular);
        for (config, dt) in [(config, MS), (config, Micros(4_000)), (parity, MS)] {
            let period_s = 1.0 / config.cutoff_hz();
            let mut kalman = filter(config, 1);
            let mut power = 0.0;
            let steps = (40.0 * period_s / dt.as_seconds()) as i64;
            for k in 0..steps {
                let t = Micros(k * dt.0);
                let phase = std::f64::consts::TAU * t.as_seconds() / period_s;
                kalman.update(t, &[phase.sin() as f32], &mut [0.0]);
                // The first half of the run contains the transient.
                if k >= steps / 2 {
                    power += kalman.positions().map(|x| x * x).sum::<f64>();
                }
            }
            // A sine has a mean power of one half, and 3 dB less is half of that.
            let gain = 2.0 * power / (steps - steps / 2) as f64;
            assert!((gain - 0.5).abs() < 0.03, "{dt}: {gain}");
        }
    }

    #[test]
    fn a_missing_measurement_is_bridged_by_the_prediction() {
        let mut kalman = filter(KalmanConfig::default(), 1);
        let mut out = [0.0];
        for k in 0..2_000_i64 {
            let z = if (1_900..1_950).contains(&k) { f32::NAN } else { k as f32 * 0.01 };
            kalman.update(Micros(k * 1_000), &[z], &mut out);
            if k > 1_500 {
                assert!((out[0] - k as f32 * 0.01).abs() < 1e-2, "{k}: {out:?}");
            }
        }
    }

    #[test]
    fn a_stream_that_starts_again_is_filtered_as_a_new_one() {
        let run = |kalman: &mut ConstantVelocityKalman| -> Vec<f64> {
            (0..50)
                .flat_map(|k| {
                    kalman.update(Micros(k * 1_000), &[(k * k % 7) as f32], &mut [0.0]);
                    kalman.positions().collect::<Vec<_>>()
                })
                .collect()
        };
        let mut kalman = filter(KalmanConfig::default(), 1);
        let first = run(&mut kalman);
        assert_eq!(first, run(&mut kalman));
    }
}
