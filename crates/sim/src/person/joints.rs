//! The thirteen joints of a posed body.

use evpose_body::PosedBody;
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use glam::Vec3;

use crate::raster::Camera;

/// Joints of a body in the world, in metres, in the order of networks.
pub type BodyJoints3 = [Vec3; BODY_JOINTS];

/// SMPL's joints in the order of networks.
const SMPL: [usize; BODY_JOINTS] = [15, 16, 17, 18, 19, 20, 21, 1, 2, 4, 5, 7, 8];

/// The middle of the head from the joint that carries it, in metres: MPII's label is the middle of
/// a box around the head.
const HEAD_M: Vec3 = Vec3::new(0.0, 0.085, 0.03);

pub(super) fn joints_m(posed: &PosedBody) -> BodyJoints3 {
    let mut joints_m = SMPL.map(|joint| Vec3::from(posed.joints[joint].translation));
    joints_m[0] = posed.joints[SMPL[0]].transform_point3(HEAD_M);
    joints_m
}

/// The joints on the image; none where they are behind the camera or outside of it.
pub(super) fn joints_px(joints_m: &BodyJoints3, camera: &Camera) -> BodyPoints {
    let sensor = camera.sensor();
    let (width, height) = (f32::from(sensor.width), f32::from(sensor.height));
    joints_m.map(|joint_m| {
        let at_px = camera.image_from_world(joint_m)?;
        let inside = (0.0..width).contains(&at_px.x) && (0.0..height).contains(&at_px.y);
        inside.then_some(at_px)
    })
}
