//! Windows of hands as a camera sees them that is turned about its own centre.
//!
//! # Model
//! A turned camera sees the same rays at other pixels, whatever is how far away: with the turn `A`
//! in the frame of the camera, the event at `K d` moves to `K A d`, and a hand of pose `M` in the
//! world, seen by the camera `C`, looks like one of pose `C⁻¹ A C M` to the camera that was not
//! turned. So arms come from all sides of the image, and hands from everywhere in it, at no cost.
//! Pixels of the result without a source stay empty, as of a sensor with dead ones.

use evpose_pose::HandParams;
use evpose_pose::rotation::{axis_angle_from_matrix, matrix_from_axis_angle};
use evpose_repr::FrameEvent;
use evpose_sim::raster::Camera;
use evpose_task::hand::{CameraTurnConfig, PerspectiveCrop};
use glam::{Affine3A, Mat3, Vec2, Vec3};

#[derive(Debug, Clone, Copy)]
pub(crate) struct CameraTurn<'a> {
    camera: &'a Camera,
    /// In the frame of the camera.
    turn: Mat3,
}

impl<'a> CameraTurn<'a> {
    /// Draws the turn of a sample: a function of `seed` and its number alone. None if cameras are
    /// not turned.
    pub(crate) fn draw(
        config: &CameraTurnConfig,
        camera: &'a Camera,
        seed: u64,
        sample: u64,
    ) -> Option<Self> {
        if config.is_none() {
            return None;
        }
        Some(Self { camera, turn: config.draw(seed, sample) })
    }

    /// Moves events; those that leave the image are gone.
    pub(crate) fn apply(&self, events: &mut Vec<FrameEvent>) {
        let (pinhole, sensor) = (self.camera.pinhole(), self.camera.sensor());
        let size = Vec2::new(f32::from(sensor.width), f32::from(sensor.height));
        events.retain_mut(|event| {
            let at_px = Vec2::new(f32::from(event.x), f32::from(event.y)) + 0.5;
            let [x, y] = ((at_px - pinhole.principal_px) / pinhole.focal_px).to_array();
            // Rows count downwards, and the camera looks along -z.
            let Some(to_px) = pinhole.image_from_camera(self.turn * Vec3::new(x, -y, -1.0)) else {
                return false;
            };
            let is_inside = to_px.cmpge(Vec2::ZERO).all() && to_px.cmplt(size).all();
            (event.x, event.y) = (to_px.x as u16, to_px.y as u16);
            is_inside
        });
    }

    /// The whole view as the camera then sees it.
    pub(crate) fn crop(&self) -> PerspectiveCrop {
        PerspectiveCrop::new(self.turn, 1.0)
    }

    /// The pose that the hand then has.
    pub(crate) fn pose(&self, pose: &HandParams) -> HandParams {
        let camera_from_world = Affine3A::from_mat4(self.camera.camera_from_world());
        // The camera turns, but poses are those of the world: into its frame and back.
        let turned =
            camera_from_world.inverse() * Affine3A::from_mat3(self.turn) * camera_from_world;
        let rotation = Mat3::from(turned.matrix3) * matrix_from_axis_angle(pose.rotation);
        HandParams {
            translation_m: turned.transform_point3(pose.translation_m),
            rotation: axis_angle_from_matrix(rotation),
            ..*pose
        }
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Polarity;
    use evpose_task::hand::{HandConfig, HandView};
    use glam::Vec2;

    use super::*;

    /// The points of a turned hand lie where its events are moved to.
    #[test]
    fn a_turned_hand_is_seen_where_its_turned_events_are() {
        let camera_turns = CameraTurnConfig { roll_deg: 180.0, tilt_deg: 6.0 };
        let config = HandConfig { camera_turns, ..HandConfig::default() };
        let view = HandView::new(&config).unwrap();
        let side = config.simulation.hands.side(0);
        let camera = config.simulation.camera();
        let pose = HandParams {
            articulation: [0.4, -0.3, 0.2, 0.0, 0.5, -0.1],
            translation_m: config.simulation.camera.centre_m + Vec3::new(0.02, 0.01, 0.03),
            rotation: Vec3::new(0.3, 1.1, -0.4),
        };
        let before = view.points(side, &pose, &[]);
        for sample in 0..20 {
            let turn = CameraTurn::draw(&config.camera_turns, &camera, 5, sample).unwrap();
            let after = view.points(side, &turn.pose(&pose), &[]);
            for (from, to) in before.image_px.iter().zip(&after.image_px) {
                let (from, to) = (from.unwrap(), to.unwrap());
                let event = FrameEvent {
                    frame: 3,
                    x: from.x as u16,
                    y: from.y as u16,
                    polarity: Polarity::On,
                };
                let mut events = vec![event];
                turn.apply(&mut events);
                if let [event] = events[..] {
                    let at = Vec2::new(f32::from(event.x), f32::from(event.y)) + 0.5;
                    // To the pixel it fell into and the one it comes from.
                    assert!(at.distance(to) < 1.6, "sample {sample}: {at} for {to}");
                }
            }
        }
    }

    #[test]
    fn without_a_range_nothing_is_turned() {
        let config = HandConfig::default();
        let camera = config.simulation.camera();
        assert!(CameraTurn::draw(&CameraTurnConfig::default(), &camera, 1, 2).is_none());
    }
}
