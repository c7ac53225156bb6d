//! Simulated people as written down.

use evpose_body::activity::{ACTIVITIES, activity_called};
use evpose_core::{Micros, SensorSize};
use serde::{Deserialize, Serialize};

use crate::SimError;
use crate::config::{BackgroundSource, BodySource, LightConfig, SensorChoice};

/// Everything about people before an event camera, but the seed. Every sequence is one person, one
/// activity, one place and one camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PeopleConfig {
    /// How many sequences.
    pub sequences: usize,
    /// Length of each.
    pub seconds: f64,
    /// Pictures per simulated second that the sensor is shown.
    pub step_hz: u32,
    /// Labels per second; divides `step_hz`.
    pub label_hz: u32,
    /// Size of the image in pixels.
    pub sensor_size: SensorSize,
    /// The body: made in code, or a file of SMPL+H.
    pub body: BodySource,
    /// Shape coefficients are uniform between minus this and this.
    pub shape_range: f32,
    /// What people do, by name; sequences go through the list.
    pub activities: Vec<String>,
    /// Share of the time, on average, for which somebody stands still in the midst of it.
    pub stillness: f32,
    /// How tall somebody who stands is, as a share of the image's height: uniform between both.
    pub height_share: [f32; 2],
    /// Angle from the bottom to the top of the image, in degrees: uniform between both.
    pub vertical_fov_deg: [f32; 2],
    /// Share of the sequences in which the camera is held by hand and turns.
    pub moving_cameras: f32,
    /// How far such a camera turns, in degrees, one standard deviation.
    pub camera_turn_deg: f32,
    /// Lights on people.
    pub lights: LightConfig,
    /// Light on everything, relative to the usual.
    pub light_level: f32,
    /// What is behind people.
    pub surroundings: SurroundingsConfig,
    /// The event camera.
    pub sensor: SensorChoice,
    /// Standard deviation, over sequences, of what is added to the contrast thresholds.
    pub threshold_sd: f64,
}

/// What is behind people.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SurroundingsConfig {
    /// Where the pictures on the wall come from.
    pub source: BackgroundSource,
    /// Exponent that makes pictures linear.
    pub gamma: f32,
    /// Share of the sequences with a wall of one colour.
    pub plain: f32,
    /// Share of the sequences in which things move behind people.
    pub moving: f32,
    /// How many such things, at most.
    pub things: usize,
}

impl Default for PeopleConfig {
    fn default() -> Self {
        Self {
            sequences: 120,
            seconds: 5.0,
            step_hz: 500,
            label_hz: 100,
            sensor_size: SensorSize { width: 346, height: 260 },
            body: BodySource::default(),
            shape_range: 1.5,
            activities: ["walking", "waving", "jumping", "boxing", "sitting", "turning"]
                .map(str::to_owned)
                .to_vec(),
            stillness: 0.2,
            height_share: [0.4, 0.9],
            vertical_fov_deg: [35.0, 55.0],
            moving_cameras: 0.15,
            camera_turn_deg: 2.0,
            lights: LightConfig::default(),
            light_level: 1.0,
            surroundings: SurroundingsConfig::default(),
            sensor: SensorChoice::Preset("davis346".to_owned()),
            threshold_sd: 0.02,
        }
    }
}

impl Default for SurroundingsConfig {
    fn default() -> Self {
        Self {
            source: BackgroundSource::Procedural(42),
            gamma: 2.2,
            plain: 0.15,
            moving: 0.3,
            things: 4,
        }
    }
}

impl PeopleConfig {
    /// Checks what types cannot.
    ///
    /// # Errors
    /// The first field that makes no sense.
    pub fn validate(&self) -> Result<(), SimError> {
        let refuse = |field, value: String, reason| Err(SimError::Config { field, value, reason });
        let shares = [
            ("stillness", self.stillness),
            ("moving_cameras", self.moving_cameras),
            ("surroundings.plain", self.surroundings.plain),
            ("surroundings.moving", self.surroundings.moving),
        ];
        if let Some((field, share)) = shares.into_iter().find(|(_, x)| !(0.0..=1.0).contains(x)) {
            return refuse(field, share.to_string(), "a share is from 0 to 1");
        }
        if self.stillness >= 1.0 {
            return refuse(
                "stillness",
                self.stillness.to_string(),
                "somebody has to move: below 1",
            );
        }
        if !(self.seconds > 0.0 && self.seconds.is_finite()) {
            return refuse("seconds", self.seconds.to_string(), "must be a positive number");
        }
        if self.step_hz == 0 || !1_000_000u32.is_multiple_of(self.step_hz) {
            return refuse("step_hz", self.step_hz.to_string(), "must divide a million");
        }
        if self.label_hz == 0 || !self.step_hz.is_multiple_of(self.label_hz) {
            return refuse("label_hz", self.label_hz.to_string(), "must divide step_hz");
        }
        if self.sensor_size.width < 32 || self.sensor_size.height < 32 {
            return refuse(
                "sensor_size",
                self.sensor_size.to_string(),
                "at least 32 pixels a side",
            );
        }
        for (field, [low, high], ends) in [
            ("height_share", self.height_share, [0.05, 2.0]),
            ("vertical_fov_deg", self.vertical_fov_deg, [5.0, 120.0]),
        ] {
            if !(ends[0] <= low && low <= high && high <= ends[1]) {
                let reason = "the smaller end first, both in their range";
                return refuse(field, format!("[{low}, {high}]"), reason);
            }
        }
        if self.activities.is_empty() {
            return refuse("activities", "[]".to_owned(), "must name at least one");
        }
        if let Some(name) = self.activities.iter().find(|name| activity_called(name).is_none()) {
            let known: Vec<&str> = ACTIVITIES.iter().map(|activity| activity.name).collect();
            return Err(SimError::UnknownActivity { name: name.clone(), known });
        }
        if matches!(self.surroundings.source, BackgroundSource::Procedural(0)) {
            return refuse("surroundings.source", "0".to_owned(), "at least one picture");
        }
        Ok(())
    }

    /// Time from one step to the next.
    pub fn step(&self) -> Micros {
        Micros(Micros::SECOND.0 / i64::from(self.step_hz))
    }

    /// Steps in a sequence.
    pub fn steps(&self) -> u64 {
        (self.seconds * f64::from(self.step_hz)).round() as u64
    }

    /// Steps from one label to the next.
    pub fn steps_per_label(&self) -> u64 {
        u64::from(self.step_hz / self.label_hz)
    }
}
