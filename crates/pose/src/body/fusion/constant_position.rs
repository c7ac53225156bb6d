//! A Kalman filter of a joint that rests but for noise.

use glam::DVec2;

use super::FusionConfig;
use super::filter::JointFilter;

/// hpe-core's `kfEstimator`.
///
/// # Model
/// ```text
///   predict  P += q dt      q = position_noise_px2_per_s
///   detect   z,             R = detection_variance_px2
///   velocity z = x + v dt,  R = displacement_variance_px2
///   update   K = P / (P + R),  x += K (z - x),  P = (1 - K) P
/// ```
///
/// Both axes have the same `P`.
#[derive(Debug, Clone, Copy)]
pub(super) struct ConstantPosition {
    position_px: DVec2,
    variance_px2: f64,
}

impl ConstantPosition {
    pub(super) fn correct(&mut self, measured_px: DVec2, variance_px2: f64) {
        let total = self.variance_px2 + variance_px2;
        let gain = self.variance_px2 / total;
        self.position_px += (measured_px - self.position_px) * gain;
        // Not `(1 - gain) P`, whose rounding can be below zero.
        self.variance_px2 = self.variance_px2 * variance_px2 / total;
    }

    /// Moves the joint, whose position becomes no less certain by it.
    pub(super) fn shift(&mut self, by_px: DVec2) {
        self.position_px += by_px;
    }
}

impl JointFilter for ConstantPosition {
    const ALL_CLOCKS_MOVE: bool = false;

    fn start(position_px: DVec2, config: &FusionConfig) -> Self {
        let variance_px2 = if config.parity { 0.0 } else { config.detection_variance_px2 };
        Self { position_px, variance_px2 }
    }

    fn advance(&mut self, dt_s: f64, config: &FusionConfig) {
        self.variance_px2 += config.position_noise_px2_per_s * dt_s;
    }

    fn detect(&mut self, position_px: DVec2, config: &FusionConfig) {
        self.correct(position_px, config.detection_variance_px2);
    }

    fn measure_velocity(&mut self, px_per_s: DVec2, dt_s: f64, config: &FusionConfig) {
        self.correct(self.position_px + px_per_s * dt_s, config.displacement_variance_px2);
    }

    fn position_px(&self, _: f64) -> DVec2 {
        self.position_px
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The variance before a detection solves `P² - Q P - Q R = 0`.
    #[test]
    fn in_steady_state_the_variance_is_that_of_the_riccati_equation() {
        let config = FusionConfig::default();
        let (q, r) = (config.position_noise_px2_per_s * 0.02, config.detection_variance_px2);
        let want = 0.5 * (q + (q * q + 4.0 * q * r).sqrt());
        let mut filter = ConstantPosition::start(DVec2::ZERO, &config);
        for _ in 0..500 {
            filter.advance(0.02, &config);
            assert!(filter.variance_px2 > 0.0);
            let before = filter.variance_px2;
            filter.detect(DVec2::ONE, &config);
            assert!(filter.variance_px2 < before.min(r));
        }
        filter.advance(0.02, &config);
        assert!((filter.variance_px2 - want).abs() < 1e-9, "{} and {want}", filter.variance_px2);
        assert!((filter.position_px - DVec2::ONE).length() < 1e-6);
    }
}
