//! Labelled joints in the frame of a fit.

use evpose_camera::ViewAdaptor;
use evpose_pose::JointFrame;
use evpose_task::hand::HandView;
use glam::{Vec2, Vec3};

use super::format::HandJoints;

/// Fewest labelled joints that determine a hand, in space and on the image.
const MIN_JOINTS: [usize; 2] = [6, 8];

/// Labelled joints; none where not labelled.
#[derive(Debug, Clone, Copy)]
pub(super) enum Target {
    /// Metres in the frame of the camera: x right, y down, z forwards.
    Space([Option<Vec3>; 21]),
    /// Pixels of the view.
    Image([Option<Vec2>; 21]),
}

impl Target {
    /// Joints before the camera of `adaptor`, or their mirror image; none if there are too few.
    pub(super) fn new(
        joints: &HandJoints,
        view: &HandView,
        adaptor: &ViewAdaptor,
        is_mirrored: bool,
    ) -> Option<Self> {
        match joints {
            HandJoints::Metres(joints_m, frame) => {
                // The fit is of one side: a hand of the other is fitted as its mirror image.
                let mirror = if is_mirrored { -1.0 } else { 1.0 };
                // Into OpenCV's frame, in which the fit looks along z.
                let in_camera = joints_m.map(|at_m| {
                    let at_m = match frame {
                        JointFrame::Camera => at_m?,
                        JointFrame::World => opencv(view.camera_points(&[at_m?])[0]),
                    };
                    Some(Vec3::new(mirror * at_m.x, at_m.y, at_m.z))
                });
                let count = in_camera.iter().flatten().count();
                (count >= MIN_JOINTS[0]).then_some(Self::Space(in_camera))
            }
            HandJoints::Pixels(joints_px) => {
                let width_px = f32::from(adaptor.view().sensor.width);
                let in_view = joints_px.map(|at_px| {
                    let at_px = adaptor.view_from_sensor(at_px?)?;
                    // Coordinates count from the edge of the first pixel: the mirror image of 0 is
                    // the width.
                    let x = if is_mirrored { width_px - at_px.x } else { at_px.x };
                    Some(Vec2::new(x, at_px.y))
                });
                let count = in_view.iter().flatten().count();
                (count >= MIN_JOINTS[1]).then_some(Self::Image(in_view))
            }
        }
    }
}

/// From y up, looking along -z, to y down, looking along z, and back.
pub(super) fn opencv(at_m: Vec3) -> Vec3 {
    Vec3::new(at_m.x, -at_m.y, -at_m.z)
}
