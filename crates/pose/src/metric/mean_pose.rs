//! The mean of many hand poses: the best guess without looking, and so the predictor to beat.
//!
//! # Model
//! Articulation and translation are arithmetic means. A mean of axis-angle vectors would be off
//! where they jump at π, so the rotation is the one of least squared distance between matrices,
//! `Σ ‖R − Rᵢ‖²`: the eigenvector of the largest eigenvalue of `Σ qᵢ qᵢᵀ` over unit quaternions.
//!
//! # Source
//! Markley, Cheng, Crassidis, Oshman, *Averaging quaternions*, J. Guidance 30(4), 2007.

use glam::{DMat4, DQuat, DVec3, DVec4};

use crate::HandParams;
use crate::rotation::{axis_angle_from_quaternion, quaternion};

/// An accumulator of hand poses.
#[derive(Debug, Clone, Default)]
pub struct MeanPose {
    count: u64,
    articulation: [f64; 6],
    translation_m: DVec3,
    /// Columns of `Σ q qᵀ`.
    quaternions: [DVec4; 4],
}

impl MeanPose {
    /// Adds a pose.
    pub fn push(&mut self, pose: &HandParams) {
        self.count += 1;
        for (sum, &value) in self.articulation.iter_mut().zip(&pose.articulation) {
            *sum += f64::from(value);
        }
        self.translation_m += pose.translation_m.as_dvec3();
        let q = DVec4::from(quaternion(pose.rotation));
        // q and -q are one rotation with the same q qᵀ, so that no sign must be chosen.
        for (column, value) in self.quaternions.iter_mut().zip(q.to_array()) {
            *column += q * value;
        }
    }

    /// The mean of the poses so far.
    pub fn mean(&self) -> Option<HandParams> {
        let scale = 1.0 / self.count as f64;
        (self.count > 0).then(|| HandParams {
            articulation: self.articulation.map(|sum| (sum * scale) as f32),
            translation_m: (self.translation_m * scale).as_vec3(),
            rotation: axis_angle_from_quaternion(self.dominant()).as_vec3(),
        })
    }

    /// The eigenvector of the largest eigenvalue.
    fn dominant(&self) -> DQuat {
        // Each squaring squares the ratio of the eigenvalues: 40 leave only the largest.
        let [x, y, z, w] = self.quaternions;
        let mut power = DMat4::from_cols(x, y, z, w);
        for _ in 0..40 {
            // Without scaling, the squares would overflow within a few steps.
            let trace = power.diagonal().element_sum();
            power *= 1.0 / trace;
            power *= power;
        }
        let columns = [power.x_axis, power.y_axis, power.z_axis, power.w_axis];
        // Every column points along the eigenvector; rounding harms the longest one least.
        let longest =
            columns.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        longest.and_then(DVec4::try_normalize).map_or(DQuat::IDENTITY, DQuat::from_vec4)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::rotation::{canonical_axis_angle, geodesic_rad};

    fn mean(rotations: impl IntoIterator<Item = Vec3>) -> Vec3 {
        let mut mean = MeanPose::default();
        for rotation in rotations {
            mean.push(&HandParams { rotation, ..HandParams::default() });
        }
        mean.mean().expect("poses").rotation
    }

    #[test]
    fn the_mean_of_one_pose_is_that_pose() {
        let pose = HandParams {
            articulation: [0.5, -1.0, 0.25, 1.5, 0.0, -2.0],
            translation_m: Vec3::new(0.1, -0.2, 0.3),
            rotation: Vec3::new(0.4, -1.2, 2.0),
        };
        let mut accumulator = MeanPose::default();
        assert!(accumulator.mean().is_none());
        (0..3).for_each(|_| accumulator.push(&pose));
        let mean = accumulator.mean().expect("poses");
        let differences = mean.to_array().into_iter().zip(pose.to_array()).map(|(a, b)| a - b);
        assert!(differences.map(f32::abs).fold(0.0, f32::max) < 1e-6, "{mean:?}");
    }

    #[test]
    fn rotations_about_one_axis_average_their_angles_even_past_a_half_turn() {
        let axis = Vec3::new(0.6, 0.0, 0.8);
        let average = mean([2.9, 3.1, 3.3, 3.5].map(|angle| canonical_axis_angle(axis * angle)));
        assert!(geodesic_rad(average, axis * 3.2) < 1e-5, "{average}");
    }

    #[test]
    fn no_nearby_rotation_is_closer_in_the_mean_square() {
        let set: Vec<Vec3> = (0..30)
            .map(|i| Vec3::new((i * 7 % 13) as f32, (i * 5 % 11) as f32, (i % 3) as f32) * 0.1)
            .collect();
        // ‖R − S‖² = 8 sin²(θ/2).
        let cost = |at: Vec3| -> f32 {
            set.iter().map(|&r| (0.5 * geodesic_rad(at, r)).sin().powi(2)).sum()
        };
        let average = mean(set.iter().copied());
        for step in [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| 0.02 * axis) {
            assert!(cost(average) < cost(average + step) && cost(average) < cost(average - step));
        }
    }
}
