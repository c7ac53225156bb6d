//! Settings of the Kalman filter: the published ones, and their meaning in seconds.
//!
//! # Model
//! In steady state, at steps `dt` well below its time constant, a constant-velocity filter is the
//! second-order low-pass
//!
//! ```text
//!   estimate/measurement = (√2 ω s + ω²) / (s² + √2 ω s + ω²),   ω = (σ²/R)^¼ rad/s
//! ```
//!
//! with `σ²` the variance of the acceleration and `R` that of a measurement. `dt` cancels: both
//! densities, `σ²·dt` and `R·dt`, are proportional to it. The filter follows a uniform motion
//! without lag, and its -3 dB frequency is `ω·√(2 + √5) / 2π`.
//!
//! For any `dt`, the gain on the position is (Kalata 1984), with `Λ² = σ²·dt⁴/R`,
//! `α = ((Λ + 4)·√(Λ² + 8Λ) − Λ² − 8Λ) / 8`.
//!
//! The published program moves its state by one *frame* per step but scales its process noise with
//! 0.001 *seconds*. The velocity's noise per step is then `σ_P²·dt²` in (unit/frame)², which in
//! seconds is an acceleration of variance `σ² = σ_P²/dt²`: a million times the printed number. The
//! position's own noise is negligible in both. So the default here, with one unit of time
//! throughout, takes `σ² = 10⁶·σ_P²` and smooths as the published program does:
//!
//! | setting | σ_P² | R | σ² | ω rad/s | -3 dB |
//! |---|---|---|---|---|---|
//! | regular | 0.1 | 5 | 1e5 | 11.9 | 3.9 Hz |
//! | fast | 3 | 1 | 3e6 | 41.6 | 13.6 Hz |
//! | live, fast | 0.3 | 2 | 3e5 | 19.7 | 6.4 Hz |
//! | live, slow | 0.03 | 5 | 3e4 | 8.8 | 2.9 Hz |
//!
//! # Source
//! EventHands supplement, Eq. 4 to 6, and its program's settings. Kalata, *The tracking index*,
//! IEEE Trans. Aerospace and Electronic Systems 20(2), 1984.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::PoseError;

/// The step of the published process noise, seconds.
pub(super) const PUBLISHED_STEP_S: f64 = 1e-3;
/// Its inverse, which keeps the converted settings round.
const PUBLISHED_RATE_HZ: f64 = 1e3;

/// Noise settings of the published program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NoiseSetting {
    /// For recordings at normal speed: every published result.
    Regular,
    /// For slow-motion video.
    Fast,
    /// Live, while the hand moves fast.
    LiveFast,
    /// Live otherwise.
    LiveSlow,
}

impl NoiseSetting {
    /// `σ_P²` and `R` as published.
    fn published(self) -> (f64, f64) {
        match self {
            Self::Regular => (0.1, 5.0),
            Self::Fast => (3.0, 1.0),
            Self::LiveFast => (0.3, 2.0),
            Self::LiveSlow => (0.03, 5.0),
        }
    }
}

/// Time step of an update.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeStep {
    /// The time since the last measurement, in seconds, in the motion and in its noise.
    #[default]
    Elapsed,
    /// One frame in the motion, 0.001 s in its noise, whatever the time: the published program.
    PublishedFrame,
}

/// State before the first update.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InitialState {
    /// At the first measurement and at rest.
    #[default]
    FirstMeasurement,
    /// At zero and at rest before the first measurement: the published live program.
    Zero,
    /// All measured values and then as many zeros, read as position, velocity, position, …: the
    /// published offline program. Its first output is the first measurement all the same.
    Concatenated,
}

/// Noise of one part of a hand's parameters, as a filter assumes it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseVariances {
    /// Variance of the acceleration, (unit/s²)².
    pub acceleration: f64,
    /// Variance of a measurement, unit².
    pub measurement: f64,
}

impl NoiseVariances {
    /// Those of a filter with a -3 dB frequency in Hz, in steady state.
    pub fn with_cutoff(cutoff_hz: f64, measurement: f64) -> Self {
        let omega_rad_per_s = cutoff_hz * TAU / (2.0 + 5f64.sqrt()).sqrt();
        Self { acceleration: omega_rad_per_s.powi(4) * measurement, measurement }
    }

    /// That frequency.
    pub fn cutoff_hz(&self) -> f64 {
        let omega_rad_per_s = (self.acceleration / self.measurement).powf(0.25);
        omega_rad_per_s * (2.0 + 5f64.sqrt()).sqrt() / TAU
    }
}

/// Noise of the three parts of a hand's parameters: fingers, wrist and rotation are measured with
/// different accuracy and move at different speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandNoise {
    /// Of the six coefficients, dimensionless.
    pub articulation: NoiseVariances,
    /// Of the wrist, in metres.
    pub translation: NoiseVariances,
    /// Of the axis-angle vector, in radians.
    pub rotation: NoiseVariances,
}

impl HandNoise {
    /// The parts with their numbers of values, in the order of the parameters.
    pub(super) fn parts(&self) -> [(usize, NoiseVariances); 3] {
        [(6, self.articulation), (3, self.translation), (3, self.rotation)]
    }
}

/// Settings of a [`super::ConstantVelocityKalman`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct KalmanConfig {
    /// Variance of the acceleration, (unit/s²)²; with [`TimeStep::PublishedFrame`], `σ_P²`.
    pub acceleration_variance: f64,
    /// Variance of a measurement, unit². Only its ratio to the other matters in steady state.
    pub measurement_variance: f64,
    /// Time step of an update.
    pub time_step: TimeStep,
    /// State before the first update.
    pub initial_state: InitialState,
    /// Variances of each part of a hand's parameters, in place of the two above: those that a
    /// training estimates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hand: Option<HandNoise>,
}

impl KalmanConfig {
    /// The smoothing of a published setting, in consistent units.
    pub fn new(setting: NoiseSetting) -> Self {
        let (published, measurement_variance) = setting.published();
        Self {
            acceleration_variance: published * PUBLISHED_RATE_HZ * PUBLISHED_RATE_HZ,
            measurement_variance,
            time_step: TimeStep::Elapsed,
            initial_state: InitialState::FirstMeasurement,
            hand: None,
        }
    }

    /// A setting number for number as in the published programs, offline or live by its name.
    pub fn parity(setting: NoiseSetting) -> Self {
        let (acceleration_variance, _) = setting.published();
        let initial_state = match setting {
            NoiseSetting::Regular | NoiseSetting::Fast => InitialState::Concatenated,
            NoiseSetting::LiveFast | NoiseSetting::LiveSlow => InitialState::Zero,
        };
        Self {
            acceleration_variance,
            time_step: TimeStep::PublishedFrame,
            initial_state,
            ..Self::new(setting)
        }
    }

    /// The -3 dB frequency of the filter in steady state, in Hz.
    ///
    /// With [`TimeStep::PublishedFrame`], for 1000 measurements per second.
    pub fn cutoff_hz(&self) -> f64 {
        let acceleration = match self.time_step {
            TimeStep::Elapsed => self.acceleration_variance,
            // The published noise is that of a frame of 1 ms: in seconds, a million times as much.
            TimeStep::PublishedFrame => {
                self.acceleration_variance * PUBLISHED_RATE_HZ * PUBLISHED_RATE_HZ
            }
        };
        NoiseVariances { acceleration, measurement: self.measurement_variance }.cutoff_hz()
    }

    /// Refuses variances that are not positive and finite.
    pub(super) fn validate(&self) -> Result<(), PoseError> {
        let hand = self.hand.iter().flat_map(|noise| {
            let [a, t, r] = noise.parts().map(|(_, part)| part);
            [
                ("hand.articulation.acceleration", a.acceleration),
                ("hand.articulation.measurement", a.measurement),
                ("hand.translation.acceleration", t.acceleration),
                ("hand.translation.measurement", t.measurement),
                ("hand.rotation.acceleration", r.acceleration),
                ("hand.rotation.measurement", r.measurement),
            ]
        });
        let all = [
            ("acceleration_variance", self.acceleration_variance),
            ("measurement_variance", self.measurement_variance),
        ];
        for (field, value) in all.into_iter().chain(hand) {
            let is_variance = value > 0.0 && value.is_finite();
            PoseError::unless(is_variance, field, value, "positive and finite")?;
        }
        Ok(())
    }
}

impl Default for KalmanConfig {
    fn default() -> Self {
        Self::new(NoiseSetting::Regular)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cutoffs_are_those_of_the_table() {
        for (setting, hz) in [
            (NoiseSetting::Regular, 3.9),
            (NoiseSetting::Fast, 13.6),
            (NoiseSetting::LiveFast, 6.4),
            (NoiseSetting::LiveSlow, 2.9),
        ] {
            let ours = KalmanConfig::new(setting).cutoff_hz();
            assert!((ours - hz).abs() < 0.05, "{setting:?}: {ours}");
            let theirs = KalmanConfig::parity(setting).cutoff_hz();
            assert!((ours - theirs).abs() < 1e-9 * hz, "{setting:?}: {ours} and {theirs}");
        }
    }

    #[test]
    fn variances_of_a_cutoff_have_it() {
        for cutoff_hz in [0.5, 3.9, 60.0] {
            let variances = NoiseVariances::with_cutoff(cutoff_hz, 0.02);
            assert!((variances.cutoff_hz() / cutoff_hz - 1.0).abs() < 1e-9, "{variances:?}");
        }
    }

    #[test]
    fn the_consistent_settings_are_round() {
        let variances = [
            NoiseSetting::Regular,
            NoiseSetting::Fast,
            NoiseSetting::LiveFast,
            NoiseSetting::LiveSlow,
        ]
        .map(|setting| KalmanConfig::new(setting).acceleration_variance);
        assert_eq!(variances, [1e5, 3e6, 3e5, 3e4]);
    }

    #[test]
    fn a_variance_must_be_positive_and_finite() {
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let config = KalmanConfig { measurement_variance: value, ..KalmanConfig::default() };
            let error = config.validate().expect_err("refused");
            assert!(error.to_string().contains("measurement_variance"), "{error}");
        }
    }
}
