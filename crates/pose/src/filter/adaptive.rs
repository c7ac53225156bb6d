//! A Kalman filter of hand poses that smooths little while the hand moves fast and more otherwise.
//!
//! # Model
//! Two filters see every measurement. The *detector* has fixed settings; where its innovation `y =
//! z − x` exceeds `innovation_limit` in any of the 12 parameters, whatever their unit (coefficients
//! and radians; metres never get there), the hand is fast. The *main* filter then takes this
//! measurement with the fast settings, and otherwise with the slow ones; its state and covariance
//! carry over. Only past and present measurements count.
//!
//! Rotations are followed through π by both filters, see [`HandFilter`]: the sign jump of a
//! canonical axis-angle vector is neither a fast motion nor a sweep.
//!
//! # Source
//! EventHands, live pipeline: detector and slow settings σ_P² = 0.03, R = 5; fast settings 0.3 and
//! 2; limit 0.7. What they mean in seconds: [`KalmanConfig`].

use evpose_core::Micros;
use serde::{Deserialize, Serialize};

use super::{HandFilter, HandFilterConfig, KalmanConfig, NoiseSetting};
use crate::{HandParams, PoseError};

/// Settings of an [`AdaptiveHandFilter`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AdaptiveFilterConfig {
    /// Innovation of the detector above which the hand is fast.
    pub innovation_limit: f64,
    /// Whether rotations are followed through π.
    pub unwrap_rotation: bool,
    /// The filter whose innovation is compared with the limit.
    pub detector: KalmanConfig,
    /// Settings of the main filter while the hand is slow.
    pub slow: KalmanConfig,
    /// Settings of the main filter while the hand is fast.
    pub fast: KalmanConfig,
}

impl AdaptiveFilterConfig {
    /// The settings of the published live program.
    pub fn parity() -> Self {
        Self { unwrap_rotation: false, ..Self::from_settings(KalmanConfig::parity) }
    }

    fn from_settings(setting: impl Fn(NoiseSetting) -> KalmanConfig) -> Self {
        Self {
            innovation_limit: 0.7,
            unwrap_rotation: true,
            detector: setting(NoiseSetting::LiveSlow),
            slow: setting(NoiseSetting::LiveSlow),
            fast: setting(NoiseSetting::LiveFast),
        }
    }
}

impl Default for AdaptiveFilterConfig {
    fn default() -> Self {
        Self::from_settings(KalmanConfig::new)
    }
}

/// A filter of hand poses with two settings and a detector that chooses between them.
#[derive(Debug, Clone)]
pub struct AdaptiveHandFilter {
    config: AdaptiveFilterConfig,
    detector: HandFilter,
    main: HandFilter,
    is_fast: bool,
}

impl AdaptiveHandFilter {
    /// A filter that has seen nothing yet.
    ///
    /// # Errors
    /// If a variance is not positive and finite, or the limit negative or no number.
    pub fn new(config: &AdaptiveFilterConfig) -> Result<Self, PoseError> {
        let AdaptiveFilterConfig { innovation_limit, unwrap_rotation, .. } = *config;
        let is_limit = innovation_limit >= 0.0 && innovation_limit.is_finite();
        PoseError::unless(is_limit, "innovation_limit", innovation_limit, "a number from 0")?;
        // The other two are checked by the filters that begin with them.
        config.fast.validate()?;
        let filter = |kalman| HandFilter::new(&HandFilterConfig { kalman, unwrap_rotation });
        let (detector, main) = (filter(config.detector)?, filter(config.slow)?);
        Ok(Self { config: *config, detector, main, is_fast: false })
    }

    /// The estimate for time `t` from the measurement of time `t` and all before.
    pub fn update(&mut self, t: Micros, measured: &HandParams) -> HandParams {
        self.detector.update(t, measured);
        // The detector comes first, since it chooses the settings for this very measurement.
        self.is_fast = self.detector.largest_innovation() > self.config.innovation_limit;
        self.main.retune(if self.is_fast { self.config.fast } else { self.config.slow });
        self.main.update(t, measured)
    }

    /// Whether the last measurement was taken with the fast settings.
    pub fn is_fast(&self) -> bool {
        self.is_fast
    }

    /// Forgets every measurement.
    pub fn reset(&mut self) {
        self.is_fast = false;
        self.detector.reset();
        // A filter begins as uncertain as its settings say.
        self.main.retune(self.config.slow);
        self.main.reset();
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::rotation::{canonical_axis_angle, geodesic_rad};

    fn filter(config: &AdaptiveFilterConfig) -> AdaptiveHandFilter {
        AdaptiveHandFilter::new(config).expect("valid settings")
    }

    fn pose(articulation: f32) -> HandParams {
        HandParams {
            articulation: [articulation, 0.0, 0.0, 0.0, 0.0, 0.0],
            ..HandParams::default()
        }
    }

    fn at_ms(k: i64) -> Micros {
        Micros(k * 1_000)
    }

    /// The filter's covariance is that of constant input; a step of known height then shows the
    /// gain of that very measurement.
    #[test]
    fn a_step_above_the_limit_is_followed_with_the_fast_gain() {
        let gain = |kalman: KalmanConfig, step: f32| -> (f32, bool) {
            let config = AdaptiveFilterConfig { slow: kalman, ..AdaptiveFilterConfig::default() };
            let mut filter = filter(&config);
            // Four seconds are many time constants, so that the gain is steady.
            for k in 0..4_000 {
                filter.update(at_ms(k), &pose(0.0));
                assert!(!filter.is_fast());
            }
            let estimate = filter.update(at_ms(4_000), &pose(step));
            (estimate.articulation[0] / step, filter.is_fast())
        };
        let slow = KalmanConfig::new(NoiseSetting::LiveSlow);
        let (small, fast_small) = gain(slow, 0.69);
        let (large, fast_large) = gain(slow, 0.72);
        assert!(!fast_small && fast_large);
        // In steady state P = αR/(1 - α): the same prediction, another Q and R in one measurement.
        let alpha = |kalman: &KalmanConfig| {
            let lambda2 = kalman.acceleration_variance * 1e-12 / kalman.measurement_variance;
            let (lambda, root) = (lambda2.sqrt(), (lambda2 + 8.0 * lambda2.sqrt()).sqrt());
            ((lambda + 4.0) * root - lambda2 - 8.0 * lambda) / 8.0
        };
        let fast = KalmanConfig::new(NoiseSetting::LiveFast);
        let noise = |kalman: &KalmanConfig| kalman.acceleration_variance * 1e-12 / 4.0;
        let predicted = alpha(&slow) / (1.0 - alpha(&slow)) * slow.measurement_variance
            - noise(&slow)
            + noise(&fast);
        let want = predicted / (predicted + fast.measurement_variance);
        assert!((f64::from(small) - alpha(&slow)).abs() < 1e-5, "{small}");
        assert!((f64::from(large) - want).abs() < 1e-5, "{large}, not {want}");
    }

    #[test]
    fn a_slow_hand_is_filtered_with_the_slow_settings_alone() {
        let config = AdaptiveFilterConfig::default();
        let mut adaptive = filter(&config);
        let plain = HandFilterConfig { kalman: config.slow, unwrap_rotation: true };
        let mut plain = HandFilter::new(&plain).expect("valid settings");
        for k in 0..2_000 {
            let measured = pose((0.002 * k as f32).sin() + 0.1 * ((k * 7 % 5) as f32 - 2.0));
            let estimate = adaptive.update(at_ms(k), &measured);
            assert_eq!(estimate, plain.update(at_ms(k), &measured));
            assert!(!adaptive.is_fast());
        }
    }

    #[test]
    fn a_jump_is_caught_up_with_sooner_than_by_the_slow_settings() {
        let after_ms = |limit: f64| -> i64 {
            let config =
                AdaptiveFilterConfig { innovation_limit: limit, ..AdaptiveFilterConfig::default() };
            let mut filter = filter(&config);
            let mut caught = |k: i64| {
                let measured = pose(if k < 500 { 0.0 } else { 2.0 });
                filter.update(at_ms(k), &measured).articulation[0] > 1.8
            };
            (0..2_000).find(|&k| caught(k)).expect("it arrives") - 500
        };
        let (adaptive, slow) = (after_ms(0.7), after_ms(1e9));
        assert!(3 * adaptive < 2 * slow, "{adaptive} ms, and {slow} ms when always slow");
    }

    /// Turning at 1 rad/s through many half turns: neither torn nor taken for fast.
    #[test]
    fn a_rotation_through_pi_neither_tears_nor_looks_fast() {
        let run = |unwrap_rotation: bool| -> (f32, bool) {
            let config =
                AdaptiveFilterConfig { unwrap_rotation, ..AdaptiveFilterConfig::default() };
            let mut filter = filter(&config);
            let axis = Vec3::new(0.36, -0.48, 0.8);
            let (mut worst_rad, mut was_fast) = (0.0f32, false);
            for k in 0..12_000 {
                let truth = axis * (0.001 * k as f32);
                let rotation = canonical_axis_angle(truth);
                let measured = HandParams { rotation, ..HandParams::default() };
                let estimate = filter.update(at_ms(k), &measured);
                // By then the filter has caught up with the velocity, which began at zero.
                if k > 1_500 {
                    worst_rad = worst_rad.max(geodesic_rad(truth, estimate.rotation));
                    was_fast |= filter.is_fast();
                }
            }
            (worst_rad, was_fast)
        };
        let (worst_rad, was_fast) = run(true);
        assert!(worst_rad < 1e-3 && !was_fast, "{worst_rad} {was_fast}");
        let (worst_rad, was_fast) = run(false);
        assert!(worst_rad > 1.0 && was_fast, "{worst_rad} {was_fast}");
    }

    #[test]
    fn what_was_reset_is_as_new_and_bad_limits_are_refused() {
        let mut used = filter(&AdaptiveFilterConfig::default());
        used.update(at_ms(0), &pose(0.0));
        used.update(at_ms(1), &pose(5.0));
        assert!(used.is_fast());
        used.reset();
        let mut new = filter(&AdaptiveFilterConfig::default());
        for k in 0..20 {
            let measured = pose((k % 3) as f32);
            assert_eq!(used.update(at_ms(k), &measured), new.update(at_ms(k), &measured));
        }
        let config =
            AdaptiveFilterConfig { innovation_limit: f64::NAN, ..AdaptiveFilterConfig::default() };
        let error = AdaptiveHandFilter::new(&config).expect_err("refused");
        assert!(error.to_string().contains("innovation_limit"), "{error}");
    }
}
