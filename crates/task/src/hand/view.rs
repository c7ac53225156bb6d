//! Hands in the image: evaluated points and vertices of a pose.

use evpose_body::{HandFit, HandSkeleton, PosedBody, ShapedBody};
use evpose_core::SensorSize;
use evpose_pose::metric::HandPoints;
use evpose_pose::{HandParams, HandPose, HandSide, PoseEstimate};
use evpose_sim::Actor;
use evpose_sim::raster::Camera;
use glam::{Vec2, Vec3};

use super::config::HandConfig;
use crate::TaskError;
use evpose_camera::{Calibration, CalibrationError, CanonicalView, ViewAdaptor};

/// The points from the wrist to the tip of the middle finger.
const MIDDLE_FINGER: [usize; 5] = [0, 9, 10, 11, 3];

/// Projection of hands: a hand model before a camera.
#[derive(Debug)]
pub struct HandView {
    actor: Actor,
    neutral: ShapedBody,
    camera: Camera,
    /// The camera on whose image points are; none if that is the canonical one.
    adaptor: Option<ViewAdaptor>,
    /// Whether poses are of the mirror image of the view.
    pub(super) is_mirrored: bool,
    /// Length of the hand over that of the mean one.
    scale: f32,
}

/// The camera of recordings by `sensor`: see [`Calibration::choose`]. Without a choice, those of the
/// size of the canonical view are taken for simulated ones.
///
/// # Errors
/// If the camera is not known, or its file cannot be read.
pub fn calibration_for(
    config: &HandConfig,
    sensor: SensorSize,
    camera: Option<&str>,
) -> Result<Calibration, CalibrationError> {
    let view = canonical_view(config);
    if camera.is_none() && sensor == view.sensor {
        let fov_deg = f64::from(config.simulation.camera.vertical_fov_deg);
        return Ok(Calibration::from_vertical_fov(sensor, fov_deg));
    }
    Calibration::choose(camera, sensor)
}

/// The view that networks of a config expect.
pub fn canonical_view(config: &HandConfig) -> CanonicalView {
    let simulation = &config.simulation;
    CanonicalView::with_vertical_fov(simulation.image_size(), simulation.camera.vertical_fov_deg)
}

impl HandView {
    /// The same view, with evaluated points on the image of another camera.
    #[must_use]
    pub fn seen_by(self, adaptor: &ViewAdaptor) -> Self {
        Self { adaptor: (!adaptor.is_identity()).then(|| adaptor.clone()), ..self }
    }

    /// The position in the view, or in its mirror image, of one on the sensor, both in pixels.
    pub(super) fn view_from_sensor(&self, sensor_px: Vec2) -> Option<Vec2> {
        let view_px = match &self.adaptor {
            Some(adaptor) => adaptor.view_from_sensor(sensor_px)?,
            None => sensor_px,
        };
        Some(self.unmirrored(view_px))
    }

    /// The position in the view of one in its mirror image, where poses are of that.
    fn unmirrored(&self, at_px: Vec2) -> Vec2 {
        let width_px = f32::from(self.camera.sensor().width);
        if self.is_mirrored { Vec2::new(width_px - at_px.x, at_px.y) } else { at_px }
    }

    /// Takes hands for ones of this length in metres, from the wrist along the bones to the tip of the middle
    /// finger, and not for the mean one. An image says how large a hand looks, never how far away it is: with
    /// its length, metres are true.
    pub(super) fn set_hand_length(&mut self, length_m: f32) {
        let skeleton = HandSkeleton::new(self.actor.body(), &self.neutral);
        let points_m = skeleton.points(&[0.0; 6]);
        let bones = MIDDLE_FINGER.windows(2);
        let mean_m: f32 = bones.map(|bone| points_m[bone[0]].distance(points_m[bone[1]])).sum();
        self.scale = length_m / mean_m;
    }

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
        Ok(Self {
            actor,
            neutral,
            camera: simulation.camera(),
            adaptor: None,
            is_mirrored: false,
            scale: 1.0,
        })
    }

    /// The evaluated points of a hand of `side` and of shape `betas` (empty: the neutral one).
    pub fn points(&self, side: HandSide, pose: &HandParams, betas: &[f32]) -> HandPoints {
        if betas.is_empty() {
            self.points_of(side, pose, &self.neutral)
        } else {
            self.points_of(side, pose, &self.actor.body().shaped(betas))
        }
    }

    /// The fit of the neutral hand of the model, of whichever side that is.
    pub(super) fn hand_fit(&self) -> HandFit {
        let side = HandSide::Right;
        let side = if self.actor.is_mirrored(side) { HandSide::Left } else { side };
        HandFit::new(self.actor.body(), &self.neutral, side)
    }

    /// Whether a hand of `side` is the mirror image of the model's.
    pub(super) fn is_mirrored_model(&self, side: HandSide) -> bool {
        self.actor.is_mirrored(side)
    }

    /// Parameters of the other hand: the mirror image of a hand in the canonical view.
    pub fn mirrored(&self, pose: &HandParams) -> HandParams {
        self.actor.mirrored(pose)
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

    /// Points of the world in the frame of the canonical camera: x right, y up, looking along -z.
    pub fn camera_points<const N: usize>(&self, world_m: &[Vec3; N]) -> [Vec3; N] {
        let camera_from_world = self.camera.camera_from_world();
        world_m.map(|point_m| camera_from_world.transform_point3(point_m))
    }

    /// Points of the world in the camera's frame as tables of poses have it, which is OpenCV's: x
    /// right, y down, z forwards.
    pub fn opencv_points<const N: usize>(&self, world_m: &[Vec3; N]) -> [Vec3; N] {
        let right = if self.is_mirrored { -1.0 } else { 1.0 };
        self.camera_points(world_m).map(|at| Vec3::new(right * at.x, -at.y, -at.z))
    }

    /// A pose with its points: its joints, or those of the neutral hand of `side`.
    pub fn estimate(&self, side: HandSide, pose: &HandPose) -> PoseEstimate {
        let (mut points, mut params) = (Box::new(self.points_seen(side, pose)), pose.params);
        if self.scale != 1.0 {
            // A larger hand that looks the same is farther away by as much: all rays stay.
            let centre_m = self.camera.camera_from_world().inverse().transform_point3(Vec3::ZERO);
            let scaled = |at_m: Vec3| centre_m + self.scale * (at_m - centre_m);
            points.world_m = points.world_m.map(scaled);
            params.translation_m = scaled(params.translation_m);
        }
        let camera_m = Box::new(self.opencv_points(&points.world_m));
        PoseEstimate::Hand { params, points, camera_m, score: pose.presence() }
    }

    /// The evaluated points of a pose: its joints, or those of the neutral hand of `side`.
    pub fn points_seen(&self, side: HandSide, pose: &HandPose) -> HandPoints {
        match &pose.joints {
            Some(joints) => self.imaged(self.world_points(&joints.camera_m)),
            None => self.points_of(side, &pose.params, &self.neutral),
        }
    }

    /// Points in the frame of the canonical camera in the world: the inverse of [`Self::camera_points`].
    pub fn world_points<const N: usize>(&self, camera_m: &[Vec3; N]) -> [Vec3; N] {
        let world_from_camera = self.camera.camera_from_world().inverse();
        camera_m.map(|point_m| world_from_camera.transform_point3(point_m))
    }

    /// The evaluated points of a hand of a shape that was made before.
    pub fn points_of(&self, side: HandSide, pose: &HandParams, shaped: &ShapedBody) -> HandPoints {
        self.imaged(self.actor.points_of(side, pose, shaped))
    }

    /// Points of the world with where they are in the image.
    pub fn imaged(&self, world_m: [Vec3; 21]) -> HandPoints {
        let image_px = world_m.map(|p| {
            // The mirror is one of the view, so that it comes before the map to the sensor.
            let view_px = self.unmirrored(self.camera.image_from_world(p)?);
            Some(match &self.adaptor {
                Some(adaptor) => adaptor.sensor_from_view(view_px),
                None => view_px,
            })
        });
        HandPoints { world_m, image_px }
    }
}
