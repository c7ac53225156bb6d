//! A Kalman filter of joints in the world.
//!
//! # Model
//! Every joint moves by itself at a constant velocity, disturbed by an acceleration that is white
//! noise. Measurements are triangulated points with their covariances. One whose distance from the
//! prediction is above the gate is left out; after `max_gap_s` without any, the joint begins anew
//! with the next.

use evpose_core::Micros;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use super::BODY_JOINTS;
use super::triangulation::TriangulatedPoint;

/// Joints in the world, in metres, in the order of networks; none where they are not known.
pub type WorldJoints = [Option<DVec3>; BODY_JOINTS];

/// Noises of the filter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SpatialFilterConfig {
    /// Spectral density of the acceleration, in m²/s³.
    pub acceleration_m2_s3: f64,
    /// Standard deviation of the first velocity, in m/s.
    pub first_velocity_m_s: f64,
    /// Largest Mahalanobis distance of a measurement.
    pub gate: f64,
    /// Longest prediction without a measurement, in seconds.
    pub max_gap_s: f64,
}

impl Default for SpatialFilterConfig {
    fn default() -> Self {
        Self { acceleration_m2_s3: 40.0, first_velocity_m_s: 1.0, gate: 4.0, max_gap_s: 0.3 }
    }
}

/// Position and velocity of a joint with the blocks of their covariance, which is symmetric.
#[derive(Debug, Clone, Copy)]
struct Track {
    position_m: DVec3,
    velocity_m_s: DVec3,
    /// Of the position, of position and velocity, of the velocity.
    covariance: [DMat3; 3],
    /// Time of the last accepted measurement.
    measured: Micros,
}

impl Track {
    fn begin(point: &TriangulatedPoint, t: Micros, config: &SpatialFilterConfig) -> Self {
        let speed = DMat3::IDENTITY * config.first_velocity_m_s.powi(2);
        Self {
            position_m: point.position_m,
            velocity_m_s: DVec3::ZERO,
            covariance: [point.covariance_m2, DMat3::ZERO, speed],
            measured: t,
        }
    }

    /// Constant velocity over `dt_s`, with the integrals of white acceleration.
    fn predict(&mut self, dt_s: f64, config: &SpatialFilterConfig) {
        let [position, both, velocity] = self.covariance;
        let noise = |power: i32, by: f64| {
            DMat3::IDENTITY * (config.acceleration_m2_s3 * dt_s.powi(power) / by)
        };
        self.position_m += self.velocity_m_s * dt_s;
        self.covariance = [
            position + (both + both.transpose()) * dt_s + velocity * dt_s.powi(2) + noise(3, 3.0),
            both + velocity * dt_s + noise(2, 2.0),
            velocity + noise(1, 1.0),
        ];
    }

    /// Takes a measurement, unless it is beyond the gate.
    fn update(&mut self, point: &TriangulatedPoint, t: Micros, config: &SpatialFilterConfig) {
        let [position, both, velocity] = self.covariance;
        let information = (position + point.covariance_m2).inverse();
        let innovation = point.position_m - self.position_m;
        // A point further away than noise explains is a wrong detection, not a motion.
        if innovation.dot(information * innovation) > config.gate.powi(2) {
            return;
        }
        // `both` is the covariance of position and velocity, in this order.
        let gain = [position * information, both.transpose() * information];
        self.position_m += gain[0] * innovation;
        self.velocity_m_s += gain[1] * innovation;
        self.covariance =
            [position - gain[0] * position, both - gain[0] * both, velocity - gain[1] * both];
        // Rejected points do not come here: they must not keep a wrong track alive.
        self.measured = t;
    }
}

/// The filter of a person.
#[derive(Debug, Clone)]
pub struct SpatialFilter {
    config: SpatialFilterConfig,
    tracks: [Option<Track>; BODY_JOINTS],
    now: Option<Micros>,
}

impl SpatialFilter {
    /// A filter that knows nothing yet.
    pub fn new(config: SpatialFilterConfig) -> Self {
        Self { config, tracks: [None; BODY_JOINTS], now: None }
    }

    /// Takes the points of time `t`, which is not before the last one, and returns the joints.
    pub fn update(
        &mut self,
        t: Micros,
        points: &[Option<TriangulatedPoint>; BODY_JOINTS],
    ) -> WorldJoints {
        // Before the first points no time has passed.
        let dt_s = self.now.map_or(0.0, |now| (t - now).as_seconds().max(0.0));
        self.now = Some(t);
        for (track, point) in self.tracks.iter_mut().zip(points) {
            if let Some(known) = track {
                known.predict(dt_s, &self.config);
                if let Some(point) = point {
                    known.update(point, t, &self.config);
                }
                // Predicted for too long, a joint is lost rather than wrong.
                if (t - known.measured).as_seconds() > self.config.max_gap_s {
                    *track = None;
                }
            }
            // A track that was lost begins again with this very point.
            if track.is_none() {
                *track = point.as_ref().map(|point| Track::begin(point, t, &self.config));
            }
        }
        self.tracks.map(|track| track.map(|track| track.position_m))
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::CounterRng;

    use super::*;

    fn points(position_m: DVec3, sd_m: f64) -> [Option<TriangulatedPoint>; BODY_JOINTS] {
        let covariance_m2 = DMat3::IDENTITY * sd_m * sd_m;
        [Some(TriangulatedPoint { position_m, covariance_m2, error_px: 1.0, cameras: 2 });
            BODY_JOINTS]
    }

    fn at(k: i64) -> Micros {
        Micros(20_000 * k)
    }

    #[test]
    fn noise_is_averaged_over_a_steady_motion_without_lag() {
        let mut filter = SpatialFilter::new(SpatialFilterConfig {
            // With little acceleration, the filter averages over many points.
            acceleration_m2_s3: 0.01,
            ..SpatialFilterConfig::default()
        });
        let mut rng = CounterRng::new(3, "measurements", 0);
        let (mut measured, mut filtered) = (0.0, 0.0);
        for k in 0..400 {
            let truth = DVec3::new(0.4 * at(k).as_seconds(), 1.0, 0.0);
            let mut normal = || 0.03 * f64::from(rng.normal());
            let noisy = truth + DVec3::new(normal(), normal(), normal());
            let joint = filter.update(at(k), &points(noisy, 0.03))[4].unwrap();
            if k >= 100 {
                measured += noisy.distance_squared(truth);
                filtered += joint.distance_squared(truth);
            }
        }
        assert!(filtered < 0.12 * measured, "{filtered} of {measured}");
    }

    /// Without noise of the process and with a wide first velocity, the filter is the regression of
    /// a line on the measurements, whose variance at its end is about 4/n of one measurement's.
    #[test]
    fn the_covariance_is_that_of_a_regression() {
        let config = SpatialFilterConfig {
            acceleration_m2_s3: 0.0,
            first_velocity_m_s: 1e3,
            ..SpatialFilterConfig::default()
        };
        let mut filter = SpatialFilter::new(config);
        let count = 50;
        for k in 0..count {
            filter.update(at(k), &points(DVec3::ONE, 0.03));
        }
        let n = count as f64;
        let want = 0.03 * 0.03 * 2.0 * (2.0 * n - 1.0) / (n * (n + 1.0));
        let got = filter.tracks[0].unwrap().covariance[0].x_axis.x;
        assert!((got / want - 1.0).abs() < 1e-3, "{got} for {want}");
    }

    /// One axis by hand: the joint moves from 0 by what the gain lets through.
    #[test]
    fn one_step_is_that_of_the_textbook() {
        let (sd, speed, noise, dt) = (0.02, 0.7, 30.0, 0.02f64);
        let config = SpatialFilterConfig {
            acceleration_m2_s3: noise,
            first_velocity_m_s: speed,
            ..SpatialFilterConfig::default()
        };
        let mut filter = SpatialFilter::new(config);
        filter.update(at(0), &points(DVec3::ZERO, sd));
        let moved = DVec3::new(0.03, -0.01, 0.02);
        let joint = filter.update(at(1), &points(moved, sd))[3].unwrap();
        let [p, c, v] = [
            sd * sd + speed * speed * dt * dt + noise * dt.powi(3) / 3.0,
            speed * speed * dt + noise * dt * dt / 2.0,
            speed * speed + noise * dt,
        ];
        let gain = [p / (p + sd * sd), c / (p + sd * sd)];
        let track = filter.tracks[3].unwrap();
        assert!((joint - gain[0] * moved).length() < 1e-12, "{joint}");
        assert!((track.velocity_m_s - gain[1] * moved).length() < 1e-12);
        let covariance = [p - gain[0] * p, c - gain[0] * c, v - gain[1] * c];
        for (block, wanted) in track.covariance.into_iter().zip(covariance) {
            let rest = block - DMat3::IDENTITY * wanted;
            assert!(rest.to_cols_array().iter().all(|value| value.abs() < 1e-12), "{block}");
        }
        // Without a measurement it moves on as it did.
        let ahead = filter.update(at(3), &[None; BODY_JOINTS])[3].unwrap();
        assert!((ahead - joint - 2.0 * dt * gain[1] * moved).length() < 1e-12);
    }

    #[test]
    fn the_gate_and_the_longest_gap_are_where_they_are_said_to_be() {
        // Two measurements of one time: their difference has twice the variance of one.
        for (deviations, is_taken) in [(3.999, true), (4.001, false)] {
            let mut filter = SpatialFilter::new(SpatialFilterConfig::default());
            filter.update(at(0), &points(DVec3::ZERO, 0.02));
            let leap = DVec3::Y * (deviations * 0.02 * f64::sqrt(2.0));
            let joint = filter.update(at(0), &points(leap, 0.02))[0].unwrap();
            let wanted = if is_taken { 0.5 * leap } else { DVec3::ZERO };
            assert!((joint - wanted).length() < 1e-12, "{deviations}: {joint}");
        }
        for (gap_us, is_known) in [(300_000, true), (300_001, false)] {
            let mut filter = SpatialFilter::new(SpatialFilterConfig::default());
            filter.update(Micros(5), &points(DVec3::ZERO, 0.02));
            filter.update(Micros(200_000), &[None; BODY_JOINTS]);
            let joints = filter.update(Micros(5 + gap_us), &[None; BODY_JOINTS]);
            assert_eq!(joints[0].is_some(), is_known, "{gap_us}");
            let far = DVec3::splat(2.0);
            let found = filter.update(Micros(6 + gap_us), &points(far, 0.02))[0];
            assert_eq!(found, Some(far), "after a gap a joint begins anew");
        }
    }
}
