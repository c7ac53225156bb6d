//! Configuration of a simulation. The default is the published setting.

mod appearance;
mod body;
mod sensor;
mod validate;

use evpose_body::motion::MotionConfig;
use evpose_core::{LookAt, Micros, Pinhole, SensorSize};
use glam::{Affine3A, Quat, Vec3};
use serde::{Deserialize, Serialize};

pub use appearance::{BackgroundConfig, BackgroundSource, LightConfig, SkinConfig, SkinSource};
pub use body::{BodySource, HandModelConfig, Hands, MotionSource};
pub use sensor::SensorChoice;

use crate::SimError;
use crate::randomisation::{Randomised, RandomisedTask};
use crate::raster::Camera;
use crate::scene::FrameResponse;

/// Complete configuration of a simulation, without its seed.
///
/// # Source
/// Defaults: EventHands, supplement and published simulator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SimulationConfig {
    /// Sequence count; each sequence has its own person, motion and surroundings.
    pub sequences: usize,
    /// Length of a sequence in seconds.
    pub seconds: f64,
    /// Steps per simulated second; recordings of hands have 1000.
    pub step_hz: u32,
    /// Format of the events: a name of `evpose convert --help`, or an ending such as `raw` or `h5`; by
    /// default `evc`, and `raw` of sensors of more than 256 rows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub format: Option<String>,
    /// Period in seconds after which shape, skin, lights, background and threshold are redrawn.
    pub episode_s: f64,
    /// Size of the full image in pixels.
    pub sensor_size: SensorSize,
    /// Factor on both sides of the image; the camera sees the same.
    pub image_scale: f32,
    /// Intrinsics and pose of the camera.
    pub camera: CameraConfig,
    /// Place of the camera relative to `camera`; poses are in the coordinates of the latter.
    pub camera_pose: CameraPoseConfig,
    /// Sides of the hands.
    pub hands: Hands,
    /// Whether another hand is in view, farther away: of the other side, and without a label.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub another_hand: bool,
    /// Model of hand and arm.
    pub body: HandModelConfig,
    /// Motion of arm and hand.
    pub motion: MotionConfig,
    /// Bound of the shape coefficients, which are uniform in ±`shape_range`.
    pub shape_range: f32,
    /// Light on everything, hand and background alike, relative to the usual: 0.01 is a hundredth
    /// of it, as through a grey filter. What is clipped at reference white is clipped before.
    pub light_level: f32,
    /// Lights on the hand.
    pub lights: LightConfig,
    /// Background images behind the hand.
    pub backgrounds: BackgroundConfig,
    /// Skin texture of the hand.
    pub skin: SkinConfig,
    /// Clipping and quantisation of the frame buffer.
    pub frame: FrameResponse,
    /// The event camera.
    pub sensor: SensorChoice,
    /// Standard deviation, over episodes, of the offset of both contrast thresholds, in natural-log
    /// intensity.
    pub threshold_sd: f64,
    /// Deviations of the published program from its description.
    pub parity: ParityConfig,
    /// Ranges of the fields that differ from sequence to sequence: `wide` for those of the program,
    /// or the path of a TOML file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub randomisation: Option<String>,
}

impl Default for SimulationConfig {
    fn default() -> Self {
        Self {
            sequences: 4,
            seconds: 40_200.0,
            step_hz: 1_000,
            format: None,
            episode_s: 50.0,
            sensor_size: SensorSize::DAVIS240C,
            image_scale: 1.0,
            camera: CameraConfig::default(),
            camera_pose: CameraPoseConfig::default(),
            hands: Hands::default(),
            another_hand: false,
            body: HandModelConfig::default(),
            motion: MotionConfig::default(),
            shape_range: 2.0,
            light_level: 1.0,
            lights: LightConfig::default(),
            backgrounds: BackgroundConfig::default(),
            skin: SkinConfig::default(),
            frame: FrameResponse::default(),
            sensor: SensorChoice::default(),
            threshold_sd: 0.02,
            parity: ParityConfig::default(),
            randomisation: None,
        }
    }
}

/// Pose and field of view of the camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CameraConfig {
    /// Angle from the bottom to the top of the image, in degrees.
    pub vertical_fov_deg: f32,
    /// Position in the world, in metres.
    pub eye_m: Vec3,
    /// A point on the optical axis, in metres.
    pub centre_m: Vec3,
    /// Up direction of the image in the world.
    pub up: Vec3,
    /// Distance of the near plane in metres.
    pub near_m: f32,
}

impl Default for CameraConfig {
    fn default() -> Self {
        Self {
            vertical_fov_deg: 45.0,
            eye_m: Vec3::new(-0.45, -0.05, 0.4),
            centre_m: Vec3::new(-0.65, -0.05, 0.0),
            up: Vec3::Y,
            near_m: 0.1,
        }
    }
}

impl CameraConfig {
    /// Pose of the camera.
    pub fn placement(&self) -> LookAt {
        LookAt { eye_m: self.eye_m, centre_m: self.centre_m, up: self.up }
    }
}

/// Place of a sequence's camera relative to the one of the configuration. The hand is seen from
/// there, and its pose is expressed as if it were the configured camera: the same network serves
/// arms from any direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CameraPoseConfig {
    /// Rotation about the optical axis, in degrees: the direction from which the arm comes.
    pub roll_deg: f32,
    /// Rotation about the point looked at, sideways and upwards, in degrees.
    pub orbit_deg: [f32; 2],
    /// Distance from the point looked at, relative to the configured one.
    pub distance: f32,
}

impl Default for CameraPoseConfig {
    fn default() -> Self {
        Self { roll_deg: 0.0, orbit_deg: [0.0; 2], distance: 1.0 }
    }
}

impl CameraPoseConfig {
    /// A camera in this place relative to `base`.
    pub fn applied_to(&self, base: &LookAt) -> LookAt {
        if *self == Self::default() {
            return *base;
        }
        let back_m = base.eye_m - base.centre_m;
        let forward = -back_m.normalize();
        let right = forward.cross(base.up).normalize();
        // Not `base.up`, which may be tilted towards the line of sight: the orbit is about the
        // image's axes.
        let up = right.cross(forward);
        let [aside, above] = self.orbit_deg.map(f32::to_radians);
        let orbit = Quat::from_axis_angle(up, aside) * Quat::from_axis_angle(right, -above);
        let roll = Quat::from_axis_angle(orbit * forward, self.roll_deg.to_radians());
        LookAt {
            eye_m: base.centre_m + orbit * (back_m * self.distance),
            centre_m: base.centre_m,
            up: roll * (orbit * up),
        }
    }
}

/// Switches that reproduce deviations of the published program; off by default.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ParityConfig {
    /// Draw new episodes at frames 0, 1, N + 1, 2N + 1, … as by a clock that lags one step, instead
    /// of at 0, N, 2N, ….
    pub lagging_episode_clock: bool,
}

impl Randomised for SimulationConfig {
    const TASK: RandomisedTask = RandomisedTask::Hand;

    fn sensor_mut(&mut self) -> &mut SensorChoice {
        &mut self.sensor
    }
}

impl SimulationConfig {
    /// Reads the TOML form and checks it.
    ///
    /// # Errors
    /// Unknown fields, and what [`Self::validate`] finds.
    pub fn from_toml(text: &str) -> Result<Self, SimError> {
        let config: Self = toml::from_str(text)?;
        config.validate()?;
        Ok(config)
    }

    /// Size of the simulated image: the sensor's, scaled.
    pub fn image_size(&self) -> SensorSize {
        let scaled = |side: u16| (f32::from(side) * self.image_scale).round() as u16;
        SensorSize {
            width: scaled(self.sensor_size.width),
            height: scaled(self.sensor_size.height),
        }
    }

    /// The camera for the scaled image.
    pub fn camera(&self) -> Camera {
        let size = self.image_size();
        let pinhole = Pinhole::from_vertical_fov(size, self.camera.vertical_fov_deg);
        Camera::new(size, pinhole, &self.camera.placement(), self.camera.near_m)
    }

    /// Placement of the camera that sees the hand: `camera`, displaced by `camera_pose`.
    pub fn placement(&self) -> LookAt {
        self.camera_pose.applied_to(&self.camera.placement())
    }

    /// The camera that sees the hand, for the scaled image.
    pub fn placed_camera(&self) -> Camera {
        let own = self.camera();
        Camera::new(own.sensor(), own.pinhole(), &self.placement(), self.camera.near_m)
    }

    /// World of the labels from the world in which the hand moves: what the displaced camera sees,
    /// seen by the configured one.
    pub fn label_from_world(&self) -> Option<Affine3A> {
        (self.camera_pose != CameraPoseConfig::default()).then(|| {
            let world_from_camera = self.camera.placement().camera_from_world().inverse();
            Affine3A::from_mat4(world_from_camera * self.placement().camera_from_world())
        })
    }

    /// Time from one step to the next.
    pub fn step(&self) -> Micros {
        Micros(Micros::SECOND.0 / i64::from(self.step_hz))
    }

    /// Steps in a sequence.
    pub fn frames(&self) -> u64 {
        (self.seconds * f64::from(self.step_hz)).round() as u64
    }

    /// Steps in an episode.
    pub fn episode_frames(&self) -> u64 {
        (self.episode_s * f64::from(self.step_hz)).round() as u64
    }
}
