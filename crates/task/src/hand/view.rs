//! Hands in the image: evaluated points and vertices of a pose.

use evpose_body::{PosedBody, ShapedBody};
use evpose_pose::metric::HandPoints;
use evpose_pose::{HandParams, HandSide};
use evpose_sim::Actor;
use evpose_sim::raster::Camera;
use glam::Vec3;

use super::config::HandConfig;
use crate::TaskError;

/// Projection of hands: a hand model before a camera.
#[derive(Debug)]
pub struct HandView {
    actor: Actor,
    neutral: ShapedBody,
    camera: Camera,
}

impl HandView {
    /// The neutral shape.
    pub fn neutral(&self) -> &ShapedBody {
        &self.neutral
    }

    /// The shape of `betas`.
    pub fn shaped(&self, betas: &[f32]) -> ShapedBody {
        self.actor.body().shaped(betas)
    }

    /// The hand model and the camera of a config.
    ///
    /// # Errors
    /// If the file of the model cannot be read.
    pub fn new(config: &HandConfig) -> Result<Self, TaskError> {
        let simulation = &config.simulation;
        let actor = Actor::load(&simulation.body, &simulation.camera)?;
        let neutral = actor.body().shaped(&[]);
        Ok(Self { actor, neutral, camera: simulation.camera() })
    }

    /// The evaluated points of a hand of `side` and of shape `betas` (empty: the neutral one).
    pub fn points(&self, side: HandSide, pose: &HandParams, betas: &[f32]) -> HandPoints {
        if betas.is_empty() {
            self.points_of(side, pose, &self.neutral)
        } else {
            self.points_of(side, pose, &self.actor.body().shaped(betas))
        }
    }

    /// The faces of a hand of `side`, counter-clockwise from outside.
    pub fn faces(&self, side: HandSide) -> &[[u32; 3]] {
        self.actor.faces(side)
    }

    /// The vertices of the neutral hand of `side`: pixels to the right and down, and how far from
    /// the camera, by the scale of its wrist. None if some of it is behind the camera.
    pub fn vertices_px(
        &self,
        side: HandSide,
        pose: &HandParams,
        scratch: &mut PosedBody,
    ) -> Option<Vec<Vec3>> {
        let camera_from_world = self.camera.camera_from_world();
        let depth_m = |world_m: Vec3| -camera_from_world.transform_point3(world_m).z;
        let px_per_m = self.camera.pinhole().focal_px / depth_m(pose.translation_m);
        let projected =
            |m: Vec3| Some(self.camera.image_from_world(m)?.extend(depth_m(m) * px_per_m));
        self.actor.vertices_of(side, pose, &self.neutral, scratch).map(projected).collect()
    }

    /// The evaluated points of a hand of a shape that was made before.
    pub fn points_of(&self, side: HandSide, pose: &HandParams, shaped: &ShapedBody) -> HandPoints {
        let mut posed = PosedBody::default();
        let world_m = self.actor.points_of(side, pose, shaped, &mut posed);
        HandPoints { world_m, image_px: world_m.map(|p| self.camera.image_from_world(p)) }
    }
}
