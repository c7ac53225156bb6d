//! A simulation as written down. The default is the published setting.

mod appearance;
mod body;
mod sensor;
mod validate;

use evpose_body::motion::MotionConfig;
use evpose_core::{LookAt, Micros, Pinhole, SensorSize};
use glam::Vec3;
use serde::{Deserialize, Serialize};

pub use appearance::{BackgroundConfig, BackgroundSource, LightConfig, SkinConfig, SkinSource};
pub use body::{BodyConfig, BodySource, Hands};
pub use sensor::SensorChoice;
pub(crate) use sensor::with_thresholds_moved;

use crate::SimError;
use crate::raster::Camera;
use crate::scene::FrameResponse;

/// Everything a simulation is, but its seed.
///
/// # Source
/// Defaults: EventHands, supplement and published simulator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SimulationConfig {
    /// How many sequences, each with a person, a motion and surroundings of its own.
    pub sequences: usize,
    /// Length of each.
    pub seconds: f64,
    /// Steps per simulated second; an `.evc` file has 1000.
    pub step_hz: u32,
    /// After how long shape, skin, lights, background and threshold are drawn anew.
    pub episode_s: f64,
    /// Size of the full image in pixels.
    pub sensor_size: SensorSize,
    /// Factor on both sides of the image; the camera sees the same.
    pub image_scale: f32,
    /// The camera.
    pub camera: CameraConfig,
    /// Which hands.
    pub hands: Hands,
    /// The model of hand and arm.
    pub body: BodyConfig,
    /// How arm and hand move.
    pub motion: MotionConfig,
    /// Shape coefficients are uniform between minus this and this.
    pub shape_range: f32,
    /// Light on everything, hand and background alike, relative to the usual: 0.01 is a hundredth of
    /// it, as through a grey filter. What is clipped at reference white is clipped before.
    pub light_level: f32,
    /// Lights on the hand.
    pub lights: LightConfig,
    /// What is behind the hand.
    pub backgrounds: BackgroundConfig,
    /// What the hand is painted with.
    pub skin: SkinConfig,
    /// What the frame buffer keeps of a colour.
    pub frame: FrameResponse,
    /// The event camera.
    pub sensor: SensorChoice,
    /// Standard deviation, over episodes, of what is added to the sensor's contrast thresholds, ON
    /// and OFF alike, in natural-log intensity.
    pub threshold_sd: f64,
    /// What the published program does differently from what it describes.
    pub parity: ParityConfig,
}

impl Default for SimulationConfig {
    fn default() -> Self {
        Self {
            sequences: 4,
            seconds: 40_200.0,
            step_hz: 1_000,
            episode_s: 50.0,
            sensor_size: SensorSize::DAVIS240C,
            image_scale: 1.0,
            camera: CameraConfig::default(),
            hands: Hands::default(),
            body: BodyConfig::default(),
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
        }
    }
}

/// Where the camera stands and how wide it sees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CameraConfig {
    /// Angle from the bottom to the top of the image, in degrees.
    pub vertical_fov_deg: f32,
    /// Position in the world, in metres.
    pub eye_m: Vec3,
    /// A point on the optical axis, in metres.
    pub centre_m: Vec3,
    /// The direction that is up in the image.
    pub up: Vec3,
    /// What is nearer than this is not seen, in metres.
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
    /// Where the camera stands.
    pub fn placement(&self) -> LookAt {
        LookAt { eye_m: self.eye_m, centre_m: self.centre_m, up: self.up }
    }
}

/// Habits of the published program, off by default.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ParityConfig {
    /// Draw new episodes at frames 0, 1, N + 1, 2N + 1, … as by a clock that lags one step, instead
    /// of at 0, N, 2N, ….
    pub lagging_episode_clock: bool,
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
