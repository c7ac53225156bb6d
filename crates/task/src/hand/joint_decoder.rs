//! Poses of hands from the maps of a network of joints, of the whole view or of crops of it.

use evpose_body::fingers::HandRotations;
use evpose_body::{FittedPose, HandFit, JointObservation};
use evpose_core::SensorSize;
use evpose_pose::rotation::axis_angle_from_matrix;
use evpose_pose::{EVALUATION_JOINTS, HandJoints, HandParams, HandPose, HandSide};
use evpose_sim::raster::Camera;
use glam::{Affine3A, Mat3, Vec3};

use super::config::HandConfig;
use super::joint_grid::JointGrid;
use super::joint_observation::joint_observation;
use super::perspective_crop::PerspectiveCrop;
use super::view::HandView;
use crate::TaskError;

/// Count of joints.
const JOINTS: usize = EVALUATION_JOINTS.len();
/// Least depth of a joint: before the camera whatever a network says.
const MIN_DEPTH_M: f32 = 0.03;

/// Makes poses of the outputs of a [`JointNet`](evpose_nn::JointNet).
#[derive(Debug)]
pub struct JointDecoder {
    view: HandView,
    camera: Camera,
    side: HandSide,
    fit: HandFit,
}

impl JointDecoder {
    /// That of the hands of a config.
    ///
    /// # Errors
    /// If the hand model cannot be read.
    pub fn new(config: &HandConfig) -> Result<Self, TaskError> {
        let view = HandView::new(config)?;
        let fit = view.hand_fit();
        let side = config.simulation.hands.side(0);
        Ok(Self { view, camera: config.simulation.camera(), side, fit })
    }

    /// The pose in the view of one row of outputs, of an image of `size` that shows `crop`. Its joints lie half-way
    /// between where they are seen, at the distance of the hand that is fitted to them, and those of that hand: these
    /// bend as fingers do, the others have the proportions of the hand in view.
    pub fn pose(&self, row: &[f32], size: SensorSize, crop: &PerspectiveCrop) -> HandPose {
        let grid = JointGrid::new(&self.camera, size, crop.zoom());
        let observed = joint_observation(row, &grid);
        let (params, rotations, fitted_m) = self.fitted(&observed, grid.focal_cells(), crop.turn());
        let camera_from_world = self.camera.camera_from_world();
        let view_from_crop = crop.turn().transpose();
        let wrist_m = crop.turn() * camera_from_world.transform_point3(params.translation_m);
        let palm_m = self.fit.palm_m();
        let camera_m = std::array::from_fn(|joint| {
            // Depths are exact in palms alone: a hand that is larger than the mean one is taken for a nearer one.
            let depth_m = (palm_m * observed.depths[joint] - wrist_m.z).max(MIN_DEPTH_M);
            let seen_m = depth_m * observed.rays[joint].extend(-1.0);
            view_from_crop * seen_m.midpoint(fitted_m[joint])
        });
        let JointObservation { scores, presence, .. } = observed;
        HandPose { params, joints: Some(HandJoints { camera_m, scores, presence, rotations }) }
    }

    /// The pose in the view of joints that a camera sees that is turned by `turn`, the rotations of the joints of
    /// its digits, and its points before that camera.
    fn fitted(
        &self,
        observed: &JointObservation,
        focal_cells: f32,
        turn: Mat3,
    ) -> (HandParams, HandRotations, [Vec3; JOINTS]) {
        let is_mirrored = self.view.is_mirrored_model(self.side);
        // A hand of the other side is fitted in a mirror before the camera, whose turn it mirrors too.
        let mirror = Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 1.0));
        let (observed, turn) = match is_mirrored {
            true => {
                let rays = observed.rays.map(|ray| glam::Vec2::new(-ray.x, ray.y));
                (JointObservation { rays, ..*observed }, mirror * turn * mirror)
            }
            false => (*observed, turn),
        };
        let fitted = self.fit.fit(&observed, focal_cells);
        let points_m = self.fit.points_m(&fitted);
        let FittedPose { articulation, rotations, rotation, position_m, .. } = fitted;
        let world_from_crop = Affine3A::from_mat4(self.camera.camera_from_world()).inverse()
            * Affine3A::from_mat3(turn.transpose());
        let own = HandParams {
            articulation,
            translation_m: world_from_crop.transform_point3(position_m),
            rotation: axis_angle_from_matrix(Mat3::from(world_from_crop.matrix3) * rotation),
        };
        // In a mirror across x, turns about the other axes go the other way.
        let mirrored = |turn: Vec3| Vec3::new(turn.x, -turn.y, -turn.z);
        match is_mirrored {
            true => (
                self.view.mirrored(&own),
                rotations.map(mirrored),
                points_m.map(|at_m| mirror * at_m),
            ),
            false => (own, rotations, points_m),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::Experiment as _;
    use crate::hand::TwoPass;

    use super::*;

    /// Joints of a hand, seen by crops as they are drawn in training, give its points back.
    #[test]
    fn a_hand_of_either_side_comes_back_from_its_crops() {
        for side in [HandSide::Right, HandSide::Left] {
            let hands = if side == HandSide::Left { "left" } else { "right" };
            let overrides = [format!("simulation.hands={hands}"), "two_pass={}".to_owned()];
            let config = HandConfig::parse("task = \"hand\"", &overrides).unwrap();
            let (decoder, view) =
                (JointDecoder::new(&config).unwrap(), HandView::new(&config).unwrap());
            let two_pass = TwoPass::new(&config).unwrap().unwrap();
            let right = HandParams {
                articulation: [0.5, -0.3, 0.2, 0.1, 0.4, -0.2],
                translation_m: config.simulation.camera.centre_m + Vec3::new(0.03, 0.02, -0.1),
                rotation: Vec3::new(0.3, 0.8, -0.4),
            };
            let pose = if side == HandSide::Left { view.mirrored(&right) } else { right };
            let world_m = view.points(side, &pose, &[]).world_m;
            let camera_m = view.camera_points(&world_m);
            for sample in 0..10 {
                let crop = two_pass.draw(&pose, 3, sample);
                let at_m = camera_m.map(|at_m| crop.turn() * at_m);
                let palm_m = at_m[9].distance(at_m[0]);
                let observed = JointObservation {
                    rays: at_m.map(|at| at.truncate() / -at.z),
                    depths: at_m.map(|at| (at_m[0].z - at.z) / palm_m),
                    spread_cells: [0.0; 21],
                    scores: [1.0; 21],
                    presence: 1.0,
                };
                let (back, _, fitted_m) = decoder.fitted(&observed, 60.0, crop.turn());
                // Rays say least of depths.
                for (fitted_m, at_m) in fitted_m.iter().zip(at_m) {
                    let off_m = *fitted_m - at_m;
                    let is_near = off_m.truncate().length() < 0.006 && off_m.z.abs() < 0.012;
                    assert!(is_near, "{side:?}: {fitted_m} for {at_m}");
                }
                let points_m = view.points(side, &back, &[]).world_m;
                for (point_m, want_m) in points_m.iter().zip(world_m) {
                    assert!(point_m.distance(want_m) < 0.006, "{side:?}: {point_m} for {want_m}");
                }
            }
        }
    }
}
