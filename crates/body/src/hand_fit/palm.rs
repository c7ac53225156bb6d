//! The palm as a rigid body: where a fit of a hand starts.

use glam::{Mat3, Mat4, Quat, Vec3, Vec4};

use super::{FAR_M, JOINTS, JointObservation, NEAR_M};

/// The points that no finger moves: the wrist and the knuckles of index, middle, pinky, ring and thumb, as
/// indices of [`EVALUATION_JOINTS`](evpose_pose::EVALUATION_JOINTS).
const PALM: [usize; 6] = [0, 6, 9, 12, 15, 18];
/// The knuckle of the middle finger.
const MIDDLE_KNUCKLE: usize = 9;
/// Smallest score that counts: an image in which no joint is seen has a pose, too.
const MIN_SCORE: f32 = 1e-3;
/// Newton steps to the distance of the wrist.
const DISTANCE_STEPS: usize = 6;
/// Squarings that bring out the largest eigenvector: powers of 1024.
const SQUARINGS: usize = 10;

/// The palm of the neutral hand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Palm {
    /// From the wrist to the knuckle of the middle finger, in metres.
    pub(super) length_m: f32,
    /// Its points in the frame of the wrist, in metres.
    points_m: [Vec3; PALM.len()],
}

/// Two points of a palm: the vector between them is `along` times the depth of the wrist, and `offset_m`.
struct Pair {
    weight: f32,
    along: Vec3,
    offset_m: Vec3,
    /// Its length on the palm.
    length_m: f32,
}

impl Palm {
    /// The palm among the points of a hand.
    pub(super) fn new(points_m: &[Vec3; JOINTS]) -> Self {
        let length_m = points_m[MIDDLE_KNUCKLE].distance(points_m[0]);
        Self { length_m, points_m: PALM.map(|joint| points_m[joint]) }
    }

    /// The rotation and the position of the hand whose palm lies on its rays.
    ///
    /// # Model
    /// A point on the ray `r` that lies `d` behind the wrist, whose depth is `w`, is `(w + d) (r, -1)`. So the
    /// vector between two of them is linear in `w`, and `w` follows from the lengths that the palm has.
    pub(super) fn place(&self, observed: &JointObservation) -> (Mat3, Vec3) {
        let scores = PALM.map(|joint| observed.scores[joint].max(MIN_SCORE));
        let rays = PALM.map(|joint| observed.rays[joint].extend(-1.0));
        // No part of a palm lies farther from its wrist than one and a half of its lengths.
        let behind_m = PALM.map(|joint| self.length_m * observed.depths[joint].clamp(-1.5, 1.5));
        let depth_m = self.depth_m(&scores, &rays, &behind_m);
        let at = |k: usize| rays[k] * (depth_m + behind_m[k]).max(NEAR_M);
        self.aligned(&scores, &std::array::from_fn(at))
    }

    /// The depth of the wrist at which points lie as far from each other as those of the palm.
    fn depth_m(&self, scores: &[f32; 6], rays: &[Vec3; 6], behind_m: &[f32; 6]) -> f32 {
        let mut pairs = Vec::new();
        for i in 0..PALM.len() {
            for j in 0..i {
                pairs.push(Pair {
                    weight: scores[i] * scores[j],
                    along: rays[i] - rays[j],
                    offset_m: rays[i] * behind_m[i] - rays[j] * behind_m[j],
                    length_m: self.points_m[i].distance(self.points_m[j]),
                });
            }
        }
        // Of a hand parallel to the image, in closed form.
        let lengths: f32 = pairs.iter().map(|pair| pair.weight * pair.length_m.powi(2)).sum();
        let across: f32 = pairs.iter().map(|pair| pair.weight * pair.along.length_squared()).sum();
        let mut depth_m = (lengths / across.max(1e-9)).sqrt().clamp(NEAR_M, FAR_M);
        for _ in 0..DISTANCE_STEPS {
            let (mut slope, mut curvature) = (0.0, 1e-9);
            for &Pair { weight, along, offset_m, length_m } in &pairs {
                let between_m = along * depth_m + offset_m;
                let by_depth = along.dot(between_m) / between_m.length().max(1e-6);
                slope += weight * (between_m.length() - length_m) * by_depth;
                curvature += weight * by_depth * by_depth;
            }
            depth_m = (depth_m - slope / curvature).clamp(NEAR_M, FAR_M);
        }
        depth_m
    }

    /// The rotation and the position of the palm that bring its points nearest to others.
    ///
    /// # Source
    /// Kabsch's problem by Horn's quaternion: *Closed-form solution of absolute orientation using unit
    /// quaternions*, JOSA A 4(4), 1987. A palm is flat, which an SVD would mirror.
    fn aligned(&self, scores: &[f32; 6], to_m: &[Vec3; 6]) -> (Mat3, Vec3) {
        let total: f32 = scores.iter().sum();
        let mean = |points_m: &[Vec3; 6]| {
            points_m.iter().zip(scores).map(|(point_m, score)| *point_m * *score).sum::<Vec3>()
                / total
        };
        let (from_mean_m, to_mean_m) = (mean(&self.points_m), mean(to_m));
        // In lengths of the palm, so that the power iteration below neither overflows nor vanishes.
        let unit = 1.0 / (self.length_m * self.length_m * total);
        let s = (0..PALM.len()).fold(Mat3::ZERO, |sum, k| {
            let (from, to) = (self.points_m[k] - from_mean_m, to_m[k] - to_mean_m);
            sum + Mat3::from_cols(to * from.x, to * from.y, to * from.z) * (scores[k] * unit)
        });
        let rotation = Mat3::from_quat(largest_eigenvector(horn(&s)));
        (rotation, to_mean_m - rotation * from_mean_m)
    }
}

/// Horn's symmetric matrix, whose largest eigenvector is the rotation as `(x, y, z, w)`, of
/// `s = Σ to fromᵀ`.
fn horn(s: &Mat3) -> Mat4 {
    let at = |row: usize, column: usize| s.col(column)[row];
    let (xx, yy, zz) = (at(0, 0), at(1, 1), at(2, 2));
    let w = Vec3::new(at(2, 1) - at(1, 2), at(0, 2) - at(2, 0), at(1, 0) - at(0, 1));
    let (xy, xz, yz) = (at(0, 1) + at(1, 0), at(0, 2) + at(2, 0), at(1, 2) + at(2, 1));
    Mat4::from_cols(
        Vec4::new(xx - yy - zz, xy, xz, w.x),
        Vec4::new(xy, yy - xx - zz, yz, w.y),
        Vec4::new(xz, yz, zz - xx - yy, w.z),
        w.extend(xx + yy + zz),
    )
}

/// The unit eigenvector of the largest eigenvalue of a symmetric matrix.
fn largest_eigenvector(matrix: Mat4) -> Quat {
    let entries = matrix.to_cols_array();
    // Shifted, so that the largest eigenvalue is also that of the largest magnitude.
    let shift = entries.iter().map(|entry| entry * entry).sum::<f32>().sqrt().max(1e-12);
    let mut power = matrix + Mat4::from_diagonal(Vec4::splat(shift));
    for _ in 0..SQUARINGS {
        let trace: f32 = (0..4).map(|k| power.col(k)[k]).sum();
        power *= 1.0 / trace;
        power *= power;
    }
    // All columns are multiples of it; the longest has the smallest error.
    let columns = (0..4).map(|k| power.col(k));
    let longest = columns.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    longest.map_or(Quat::IDENTITY, |column| Quat::from_vec4(column.normalize_or(Vec4::W)))
}

#[cfg(test)]
mod tests {
    use evpose_core::CounterRng;

    use super::*;
    use crate::{BodyModel, HandSkeleton};

    #[test]
    fn a_palm_is_put_where_it_was() {
        let model = BodyModel::procedural_arm();
        let points_m = HandSkeleton::new(&model, &model.shaped(&[])).points(&[0.0; 6]);
        let palm = Palm::new(&points_m);
        assert!((0.06..0.12).contains(&palm.length_m), "{}", palm.length_m);
        for sample in 0..50 {
            let mut rng = CounterRng::new(3, "palms", sample);
            let axis = Vec3::from_array([(); 3].map(|()| rng.uniform(-1.8, 1.8)));
            let rotation = Mat3::from_quat(Quat::from_scaled_axis(axis));
            let position_m =
                Vec3::new(rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1), rng.uniform(-0.9, -0.3));
            let at_m = points_m.map(|point_m| rotation * point_m + position_m);
            let observed = JointObservation {
                rays: at_m.map(|at| at.truncate() / -at.z),
                depths: at_m.map(|at| (position_m.z - at.z) / palm.length_m),
                spread_cells: [0.0; JOINTS],
                scores: [1.0; JOINTS],
                presence: 1.0,
            };
            let (placed, placed_m) = palm.place(&observed);
            let off = placed_m.distance(position_m);
            assert!(off < 2e-3, "{sample}: {placed_m} for {position_m}");
            let turn = placed * rotation.transpose();
            assert!((turn.x_axis - Vec3::X).length() < 1e-2, "{sample}: {turn}");
            assert!((turn.y_axis - Vec3::Y).length() < 1e-2, "{sample}: {turn}");
        }
    }
}
