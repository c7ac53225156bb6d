//! How the network looks at the canonical view: once as a whole, and once at the hand it saw.

use evpose_core::{CounterRng, SensorSize};
use evpose_pose::{HandParams, HandSide};
use evpose_sim::raster::Camera;
use glam::Mat3;
use serde::{Deserialize, Serialize};

use super::camera_turns::CameraTurnConfig;
use super::config::HandConfig;
use super::look::Look;
use super::view::HandView;
use crate::TaskError;

/// Two looks at every window by one network: at the whole view, and at the hand that it saw there,
/// upright and enlarged. The view then has more pixels than the network's image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LooksConfig {
    /// Size of the network's image, in pixels, of the view's proportions.
    pub size: SensorSize,
    /// The second look shows a hand as large as it is at this distance in the whole view, in metres.
    pub distance_m: f32,
    /// The second look enlarges at most so much.
    pub max_zoom: f32,
    /// Share of the training windows that are first looks.
    pub first_probability: f32,
    /// Errors of the first look that the second is trained with.
    pub errors: LookErrors,
}

/// Largest errors of the look that a network is trained with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LookErrors {
    /// Of the direction to the hand, relative to the vertical field of view of the second look.
    pub direction: f32,
    /// Of the zoom, in natural logarithm.
    pub zoom: f32,
    /// Of the direction of the hand in the image, in degrees.
    pub roll_deg: f32,
}

impl Default for LooksConfig {
    fn default() -> Self {
        Self {
            size: SensorSize { width: 96, height: 72 },
            distance_m: 0.31,
            max_zoom: 4.0,
            first_probability: 0.4,
            errors: LookErrors::default(),
        }
    }
}

impl Default for LookErrors {
    fn default() -> Self {
        Self { direction: 0.15, zoom: 0.35, roll_deg: 45.0 }
    }
}

impl LooksConfig {
    /// Whether all values make sense for a view of `view`.
    pub fn is_valid(&self, view: SensorSize) -> bool {
        let LookErrors { direction, zoom, roll_deg } = self.errors;
        let across = u32::from(self.size.width) * u32::from(view.height);
        let same = across.abs_diff(u32::from(view.width) * u32::from(self.size.height));
        self.size.pixels() > 0
            && self.size.width <= view.width
            && 50 * same <= across
            && self.distance_m > 0.0
            && self.max_zoom >= 1.0
            && (0.0..=1.0).contains(&self.first_probability)
            && (0.0..=1.0).contains(&direction)
            && (0.0..=2.0).contains(&zoom)
            && (0.0..=180.0).contains(&roll_deg)
    }
}

/// The looks of a network's config, before its camera.
#[derive(Debug)]
pub struct Looks {
    config: LooksConfig,
    turns: CameraTurnConfig,
    camera: Camera,
    view: HandView,
    side: HandSide,
}

impl Looks {
    /// Those of a config; none if its network sees the whole view only, as it is.
    ///
    /// # Errors
    /// If the hand model cannot be read.
    pub fn new(config: &HandConfig) -> Result<Option<Self>, TaskError> {
        let Some(looks) = config.looks else { return Ok(None) };
        Ok(Some(Self {
            config: looks,
            turns: config.camera_turns,
            camera: config.simulation.camera(),
            view: HandView::new(config)?,
            side: config.simulation.hands.side(0),
        }))
    }

    /// Size of the network's image.
    pub fn size(&self) -> SensorSize {
        self.config.size
    }

    /// Size of the view.
    pub fn view_size(&self) -> SensorSize {
        self.camera.sensor()
    }

    /// The camera of the view.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The look at the hand of a pose.
    pub fn second(&self, pose: &HandParams) -> Look {
        let world_m = self.view.points(self.side, pose, &[]).world_m;
        let points_m = self.view.camera_points(&world_m);
        Look::at(&points_m, self.config.distance_m, self.config.max_zoom)
    }

    /// The look of training sample `sample` at the hand of its pose: a function of `seed` and its
    /// number alone.
    pub fn draw(&self, pose: &HandParams, seed: u64, sample: u64) -> Look {
        let mut rng = CounterRng::new(seed, "looks", sample);
        if rng.uniform(0.0, 1.0) < self.config.first_probability {
            return Look::new(self.turns.draw(seed, sample), 1.0);
        }
        let LookErrors { direction, zoom, roll_deg } = self.config.errors;
        let look = self.second(pose);
        let mut error = |largest: f32| largest * rng.uniform(-1.0, 1.0);
        let zoom = (look.zoom() * error(zoom).exp()).max(1.0);
        let half_px = 0.5 * f32::from(self.view_size().height);
        let fov_rad = 2.0 * (half_px / (zoom * self.camera.pinhole().focal_px)).atan();
        let (pan, tilt) = (fov_rad * error(direction), fov_rad * error(direction));
        let roll = error(roll_deg).to_radians();
        let error =
            Mat3::from_rotation_x(tilt) * Mat3::from_rotation_y(pan) * Mat3::from_rotation_z(roll);
        Look::new(error * look.turn(), zoom)
    }

    /// Writes the network's image of a look at the view's values, `[2][rows][columns]` both.
    pub fn fill(&self, look: &Look, values: &[f32], out: &mut [f32]) {
        look.fill(&self.camera, values, self.config.size, out);
    }
}
