//! A Kalman filter of position and velocity, either of which may be measured.

use glam::DVec2;

use super::FusionConfig;
use super::filter::JointFilter;

/// hpe-core's `constVelKalman`.
///
/// # Model
/// Along each axis, with noises `q` of the position and `s` of the velocity,
/// `dx = v dt + √q dW`, `dv = √s dW'`, from which over `dt`
///
/// ```text
///   F = [1 dt]   Q = [q dt + s dt³/3   s dt²/2]   predict  x = F x,  P = F P Fᵀ + Q
///       [0  1]       [s dt²/2          s dt   ]
/// ```
///
/// exactly: two steps are one of both their lengths. A detection measures `H = [1 0]` and a
/// velocity `H = [0 1]`; `P` after it is Joseph's, which stays positive under rounding. Both axes
/// have the same.
///
/// With parity `Q = diag(q, s) dt`. (What is published cannot run: its measurement noise is a 2x2
/// matrix for 4 measurements. It is compared with what it means.)
#[derive(Debug, Clone, Copy)]
pub(super) struct ConstantVelocity {
    position_px: DVec2,
    velocity_px_per_s: DVec2,
    covariance: Covariance,
}

/// The symmetric covariance along each axis.
#[derive(Debug, Clone, Copy)]
struct Covariance {
    position: f64,
    cross: f64,
    velocity: f64,
}

/// The gains on what was measured with variance `r` and on the other value, and the variance of the
/// first, the covariance and the variance of the second after it.
fn joseph(measured: f64, cross: f64, other: f64, r: f64) -> ([f64; 2], [f64; 3]) {
    let total = measured + r;
    let [k, l] = [measured / total, cross / total];
    let rest = 1.0 - k;
    let after = [
        rest * rest * measured + r * k * k,
        rest * (cross - l * measured) + r * k * l,
        other - 2.0 * l * cross + l * l * total,
    ];
    ([k, l], after)
}

impl JointFilter for ConstantVelocity {
    const ALL_CLOCKS_MOVE: bool = false;

    fn start(position_px: DVec2, config: &FusionConfig) -> Self {
        let [position, velocity] = if config.parity {
            [0.0; 2]
        } else {
            [config.detection_variance_px2, config.first_velocity_variance_px2_per_s2]
        };
        // Nothing couples the two yet, for one detection says nothing of the velocity.
        let covariance = Covariance { position, cross: 0.0, velocity };
        Self { position_px, velocity_px_per_s: DVec2::ZERO, covariance }
    }

    fn advance(&mut self, dt_s: f64, config: &FusionConfig) {
        self.position_px += self.velocity_px_per_s * dt_s;
        let Covariance { position, cross, velocity } = self.covariance;
        let (q, s) = (config.position_noise_px2_per_s, config.velocity_noise_px2_per_s3);
        // The noise of the velocity moves the position within the same step; hpe-core neglects it.
        let coupled = if config.parity { 0.0 } else { s * dt_s * dt_s };
        self.covariance = Covariance {
            position: position
                + dt_s * (2.0 * cross + dt_s * velocity)
                + q * dt_s
                + coupled * dt_s / 3.0,
            cross: cross + dt_s * velocity + coupled / 2.0,
            velocity: velocity + s * dt_s,
        };
    }

    fn detect(&mut self, position_px: DVec2, config: &FusionConfig) {
        let Covariance { position, cross, velocity } = self.covariance;
        let ([k, l], [position, cross, velocity]) =
            joseph(position, cross, velocity, config.detection_variance_px2);
        let innovation = position_px - self.position_px;
        self.position_px += innovation * k;
        self.velocity_px_per_s += innovation * l;
        self.covariance = Covariance { position, cross, velocity };
    }

    fn measure_velocity(&mut self, px_per_s: DVec2, _: f64, config: &FusionConfig) {
        let Covariance { position, cross, velocity } = self.covariance;
        // The roles are swapped: the velocity is measured,
        // and the position follows by the covariance.
        let ([k, l], [velocity, cross, position]) =
            joseph(velocity, cross, position, config.velocity_variance_px2_per_s2);
        let innovation = px_per_s - self.velocity_px_per_s;
        self.velocity_px_per_s += innovation * k;
        self.position_px += innovation * l;
        self.covariance = Covariance { position, cross, velocity };
    }

    fn position_px(&self, ahead_s: f64) -> DVec2 {
        self.position_px + self.velocity_px_per_s * ahead_s
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn any_filter(state: [f64; 4]) -> ConstantVelocity {
        let [x, v, correlation, size] = state;
        let covariance =
            // A correlation below 1 keeps the covariance positive; deviations are as 1 to 3.
            Covariance { position: size, cross: correlation * size * 3.0, velocity: size * 9.0 };
        let (position_px, velocity_px_per_s) = (DVec2::splat(x), DVec2::new(v, -v));
        ConstantVelocity { position_px, velocity_px_per_s, covariance }
    }

    fn is_close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-9 * a.abs().max(b.abs()).max(1.0)
    }

    proptest! {
        #[test]
        fn two_steps_are_one_of_both_their_lengths(
            state in [-500.0..500.0, -900.0..900.0, -0.9..0.9, 0.1..50.0],
            [a, b] in [0.0..0.2, 0.0..0.2],
        ) {
            let config = FusionConfig::default();
            let (mut split, mut whole) = (any_filter(state), any_filter(state));
            split.advance(a, &config);
            split.advance(b, &config);
            whole.advance(a + b, &config);
            prop_assert!(is_close(split.position_px.x, whole.position_px.x));
            let (split, whole) = (split.covariance, whole.covariance);
            prop_assert!(is_close(split.position, whole.position));
            prop_assert!(is_close(split.cross, whole.cross));
            prop_assert!(is_close(split.velocity, whole.velocity));
        }

        #[test]
        fn covariances_stay_positive_whatever_comes(
            steps in prop::collection::vec((0.0..0.3, any::<bool>()), 1..300),
            detection_deviation in -6.0..6.0, velocity_deviation in -6.0..6.0,
        ) {
            let config = FusionConfig {
                detection_variance_px2: f64::powf(10.0, detection_deviation),
                velocity_variance_px2_per_s2: f64::powf(10.0, velocity_deviation),
                ..FusionConfig::default()
            };
            let mut filter = ConstantVelocity::start(DVec2::ZERO, &config);
            for (dt_s, is_detection) in steps {
                filter.advance(dt_s, &config);
                if is_detection {
                    filter.detect(DVec2::ONE, &config);
                } else {
                    filter.measure_velocity(DVec2::ONE, dt_s, &config);
                }
                let Covariance { position, cross, velocity } = filter.covariance;
                prop_assert!(position > 0.0 && velocity > 0.0, "{filter:?}");
                prop_assert!(cross * cross < position * velocity * (1.0 + 1e-9), "{filter:?}");
            }
        }
    }

    /// Velocities alone: `P² - Q P - Q R = 0` for the variance of the velocity before each.
    #[test]
    fn in_steady_state_the_velocity_variance_is_that_of_the_riccati_equation() {
        let config = FusionConfig::default();
        let (q, r) =
            (config.velocity_noise_px2_per_s3 * 0.002, config.velocity_variance_px2_per_s2);
        let want = 0.5 * (q + (q * q + 4.0 * q * r).sqrt());
        let mut filter = ConstantVelocity::start(DVec2::ZERO, &config);
        for _ in 0..500 {
            filter.advance(0.002, &config);
            filter.measure_velocity(DVec2::new(120.0, 0.0), 0.002, &config);
        }
        filter.advance(0.002, &config);
        assert!((filter.covariance.velocity / want - 1.0).abs() < 1e-9, "{filter:?}, not {want}");
        assert!((filter.velocity_px_per_s.x - 120.0).abs() < 1e-9);
    }
}
