//! LiftMono-HPE alone: positions with depths, and how large and how far away people are.

use burn::tensor::Tensor;
use evpose_pose::body::{BODY_JOINTS, BodyPoints, number};
use evpose_task::baseline::{LiftGeometry, torso_m};
use glam::Vec2;

use crate::body::{BodyFrame, BodyFrames};

/// The depths of the joints of a frame; none where its camera is not known, or no head is before it.
pub(super) fn depths(frame: &BodyFrame) -> Option<[f32; BODY_JOINTS]> {
    let camera = frame.camera?;
    LiftGeometry::new(camera.lens, camera.sensor).depths(&camera.joints_m)
}

/// The positions of joints with their depths; those without either are not known.
pub(super) fn positions(
    points: &BodyPoints,
    frame: &BodyFrame,
) -> ([[f32; 3]; BODY_JOINTS], [f32; BODY_JOINTS]) {
    let depths = depths(frame);
    let (mut positions, mut known) = ([[0.0; 3]; BODY_JOINTS], [0.0; BODY_JOINTS]);
    for joint in 0..BODY_JOINTS {
        let depth = depths.map(|depths| depths[joint]).filter(|depth| depth.is_finite());
        if let (Some(at), Some(depth)) = (points[joint], depth) {
            // The network's expectations go from -1 to 1 over the image.
            positions[joint] = [2.0 * at.x - 1.0, 2.0 * at.y - 1.0, depth];
            known[joint] = 1.0;
        }
    }
    (positions, known)
}

/// Positions from -1 to 1 in pixels of an input, joint by joint.
pub(super) fn positions_px(positions: Tensor<3>, size_px: Vec2) -> Vec<Vec2> {
    let values: Vec<f32> = positions.detach().into_data().iter().collect();
    let pixels = |[x, y, _]: &[f32; 3]| 0.5 * (Vec2::new(*x, *y) + 1.0) * size_px;
    values.as_chunks::<3>().0.iter().map(pixels).collect()
}

/// The mean torso of the people on the images, and the smallest and the largest depth of their
/// heads, in metres; none where joints in metres are not known.
pub(super) fn torso_and_depths_m(frames: &BodyFrames) -> Option<(f32, [f32; 2])> {
    let (mut sum_m, mut count, mut depths_m) = (0.0, 0u64, [f32::INFINITY, 0.0f32]);
    for joints_m in frames.frames.iter().filter_map(|frame| Some(frame.camera?.joints_m)) {
        // The camera looks along -z.
        let head_m = -joints_m[number::HEAD].z;
        let Some(torso_m) = torso_m(&joints_m).filter(|_| head_m > 0.0) else { continue };
        sum_m += f64::from(torso_m);
        count += 1;
        depths_m = [depths_m[0].min(head_m), depths_m[1].max(head_m)];
    }
    (count > 0).then(|| ((sum_m / count as f64) as f32, depths_m))
}
