//! Configuration of simulated people.

use evpose_body::activity::{activities, activity_by_name};
use evpose_core::{Micros, SensorSize};
use serde::{Deserialize, Serialize};

use crate::SimError;
use crate::config::{BackgroundSource, BodySource, LightConfig, MotionSource, SensorChoice};
use crate::randomisation::{Randomised, RandomisedTask};

/// Largest number of people, objects or outfits.
const MAX_COUNT: usize = 256;

/// Share of what is mixed in, unless configured.
const HALF: f32 = 0.5;

fn is_half(share: &f32) -> bool {
    share.to_bits() == HALF.to_bits()
}

fn is_of_activities(motion: &MotionSource) -> bool {
    *motion == MotionSource::Activities
}

/// Complete configuration of a simulation of people, without its seed. Every sequence has one
/// person, one activity, one background and one camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PeopleConfig {
    /// Sequence count, over all cameras.
    pub sequences: usize,
    /// Length of a sequence in seconds.
    pub seconds: f64,
    /// Frames per simulated second that the sensor is exposed to.
    pub step_hz: u32,
    /// Labels per second; divides `step_hz`.
    pub label_hz: u32,
    /// Format of the events: a name of `evpose convert --help`, or an ending; `raw` by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub format: Option<String>,
    /// Size of the image in pixels.
    pub sensor_size: SensorSize,
    /// Body model: procedural, a file of SMPL+H, or a folder of MakeHuman's files. Without that
    /// folder, all people are procedural.
    pub body: BodySource,
    /// Share of the people with MakeHuman's body, if there is one.
    #[serde(skip_serializing_if = "is_half")]
    pub body_share: f32,
    /// Motion beside that of the activities. Without its folder, all motion is theirs.
    #[serde(skip_serializing_if = "is_of_activities")]
    pub motion: MotionSource,
    /// Share of the people with captured motion, if there is any.
    #[serde(skip_serializing_if = "is_half")]
    pub motion_share: f32,
    /// Bound of the shape coefficients, which are uniform in ±`shape_range`.
    pub shape_range: f32,
    /// Names of the activities; sequences cycle through the list.
    pub activities: Vec<String>,
    /// Mean share of the time in which the person stands still during the activity.
    pub stillness: f32,
    /// Height of a standing person as a share of the image height: uniform between both.
    pub height_share: [f32; 2],
    /// Angle from the bottom to the top of the image, in degrees: uniform between both.
    pub vertical_fov_deg: [f32; 2],
    /// The part of the person that is in view.
    pub framing: Framing,
    /// Number of other people, who are behind and have no labels.
    pub companions: usize,
    /// Number of objects before the person.
    pub occluders: usize,
    /// Outfits with shapes of their own (hair, hats, skirts, coats, bags) that people wear; with 0
    /// they differ in colours and proportions alone.
    pub outfits: usize,
    /// Share of the sequences in which the camera is held by hand and turns.
    pub moving_cameras: f32,
    /// Standard deviation of a hand-held camera's rotation, in degrees.
    pub camera_turn_deg: f32,
    /// Several calibrated cameras of every scene: their angles about the person in degrees, 0 before
    /// the person, positive to the person's left; DHP19 has -90, -45, 45 and 90. Every camera makes a
    /// sequence of its own, those of a scene one after another. Cameras stand still, there are no
    /// companions, and every camera sees a wall of its own behind the person.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub camera_angles_deg: Vec<f32>,
    /// Lights on people.
    pub lights: LightConfig,
    /// Light on everything, relative to the usual.
    pub light_level: f32,
    /// Background behind people.
    pub surroundings: SurroundingsConfig,
    /// The event camera.
    pub sensor: SensorChoice,
    /// Standard deviation, over sequences, of the offset of the contrast thresholds.
    pub threshold_sd: f64,
    /// Ranges of the fields that differ from sequence to sequence: `wide` for those of the program,
    /// or the path of a TOML file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub randomisation: Option<String>,
}

/// The part of a person that is in view.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Framing {
    /// All of the person, as tall as `height_share` says.
    #[default]
    Whole,
    /// The lower edge of the image is between feet and thighs.
    LegsCut,
    /// From the hips upwards.
    UpperBody,
    /// From the chest upwards.
    HeadAndShoulders,
    /// A part of a whole person: a side of the image goes through the person.
    OffEdge,
    /// Nobody.
    Nobody,
}

/// Background behind people: a plane with an image, and distractors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SurroundingsConfig {
    /// Source of the background images.
    pub source: BackgroundSource,
    /// Exponent of the images' gamma encoding.
    pub gamma: f32,
    /// Share of the sequences with a uniform background.
    pub plain: f32,
    /// Share of the sequences with distractors, which move behind people.
    pub moving: f32,
    /// Largest number of distractors of a sequence.
    // The card of the shipped `body-quick` spells it so.
    #[serde(alias = "things")]
    pub distractors: usize,
}

impl Default for PeopleConfig {
    fn default() -> Self {
        Self {
            sequences: 120,
            seconds: 5.0,
            step_hz: 500,
            label_hz: 100,
            format: None,
            sensor_size: SensorSize { width: 346, height: 260 },
            body: BodySource::default(),
            body_share: HALF,
            motion: MotionSource::default(),
            motion_share: HALF,
            shape_range: 1.5,
            activities: ["walking", "waving", "jumping", "boxing", "sitting", "turning"]
                .map(str::to_owned)
                .to_vec(),
            stillness: 0.2,
            height_share: [0.4, 0.9],
            vertical_fov_deg: [35.0, 55.0],
            framing: Framing::Whole,
            companions: 0,
            occluders: 0,
            outfits: 0,
            moving_cameras: 0.15,
            camera_turn_deg: 2.0,
            camera_angles_deg: Vec::new(),
            lights: LightConfig::default(),
            light_level: 1.0,
            surroundings: SurroundingsConfig::default(),
            sensor: SensorChoice::Preset("davis346".to_owned()),
            threshold_sd: 0.02,
            randomisation: None,
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
            distractors: 4,
        }
    }
}

impl Randomised for PeopleConfig {
    const TASK: RandomisedTask = RandomisedTask::Body;

    fn sensor_mut(&mut self) -> &mut SensorChoice {
        &mut self.sensor
    }
}

impl PeopleConfig {
    /// Checks the ranges of all fields.
    ///
    /// # Errors
    /// The first field that makes no sense.
    pub fn validate(&self) -> Result<(), SimError> {
        let refuse = |field, value: String, reason| Err(SimError::Config { field, value, reason });
        let shares = [
            ("stillness", self.stillness),
            ("moving_cameras", self.moving_cameras),
            ("body_share", self.body_share),
            ("motion_share", self.motion_share),
            ("surroundings.plain", self.surroundings.plain),
            ("surroundings.moving", self.surroundings.moving),
        ];
        // Written as inside of a range, so that NaN is refused.
        if let Some((field, share)) = shares.into_iter().find(|(_, x)| !(0.0..=1.0).contains(x)) {
            return refuse(field, share.to_string(), "a share is from 0 to 1");
        }
        if self.stillness >= 1.0 {
            return refuse(
                "stillness",
                self.stillness.to_string(),
                "must be below 1: people have to move",
            );
        }
        if !(self.seconds > 0.0 && self.seconds.is_finite()) {
            return refuse("seconds", self.seconds.to_string(), "must be a positive number");
        }
        // Steps are whole microseconds, as time stamps are.
        if self.step_hz == 0 || !1_000_000u32.is_multiple_of(self.step_hz) {
            return refuse("step_hz", self.step_hz.to_string(), "must divide a million");
        }
        // Labels are written at steps: between two of them there is no pose.
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
            // Negated, so that NaN is refused.
            if !(ends[0] <= low && low <= high && high <= ends[1]) {
                let reason = "the smaller end first, both in their range";
                return refuse(field, format!("[{low}, {high}]"), reason);
            }
        }
        if self.activities.is_empty() {
            return refuse("activities", "[]".to_owned(), "must name at least one");
        }
        if let Some(name) = self.activities.iter().find(|name| activity_by_name(name).is_none()) {
            let known: Vec<&str> = activities().map(|activity| activity.name).collect();
            return Err(SimError::UnknownActivity { name: name.clone(), known });
        }
        for (field, count) in [
            ("companions", self.companions),
            ("occluders", self.occluders),
            ("outfits", self.outfits),
        ] {
            if count > MAX_COUNT {
                return refuse(field, count.to_string(), "at most 256");
            }
        }
        if !(self.light_level > 0.0 && self.light_level.is_finite()) {
            return refuse("light_level", self.light_level.to_string(), "must be positive");
        }
        if matches!(self.surroundings.source, BackgroundSource::Procedural(0)) {
            return refuse("surroundings.source", "0".to_owned(), "at least one image");
        }
        self.lights.validate()?;
        // Last: these compare fields, most of which are checked above.
        self.validate_cameras()?;
        crate::EventFormat::of_people(self)?;
        evpose_sensor::SensorModel::from_config(&self.sensor.resolve()?)?;
        Ok(())
    }

    /// Checks the fields that several cameras need.
    fn validate_cameras(&self) -> Result<(), SimError> {
        let refuse = |field, value: String, reason| Err(SimError::Config { field, value, reason });
        let angles = &self.camera_angles_deg;
        if angles.is_empty() {
            return Ok(());
        }
        if angles.len() > MAX_COUNT || !angles.iter().all(|angle| angle.abs() <= 180.0) {
            let reason = "at most 256 angles from -180 to 180";
            return refuse("camera_angles_deg", format!("{angles:?}"), reason);
        }
        if !self.sequences.is_multiple_of(angles.len()) {
            let reason = "a multiple of the number of cameras: each makes a sequence of a scene";
            return refuse("sequences", self.sequences.to_string(), reason);
        }
        if self.moving_cameras > 0.0 {
            let reason = "0 with camera_angles_deg: calibrated cameras stand still";
            return refuse("moving_cameras", self.moving_cameras.to_string(), reason);
        }
        if self.companions > 0 {
            let reason = "0 with camera_angles_deg: nobody else may stand before a camera";
            return refuse("companions", self.companions.to_string(), reason);
        }
        Ok(())
    }

    /// Folders of the configuration that are not there, and what is done without each, in a sentence.
    pub fn missing_folders(&self) -> Vec<String> {
        let body = match &self.body {
            BodySource::MakeHuman(folder) => Some((folder, "body", "all people are procedural")),
            BodySource::Procedural | BodySource::File(_) => None,
        };
        let motion = match &self.motion {
            MotionSource::Cmu(folder) => Some((folder, "motion", "all motion is of activities")),
            MotionSource::Activities => None,
        };
        let missing = body.into_iter().chain(motion).filter(|(folder, ..)| !folder.is_dir());
        missing
            .map(|(folder, field, without)| {
                format!("simulation.{field}: no folder {}: {without}", folder.display())
            })
            .collect()
    }

    /// Number of cameras of a scene.
    pub fn cameras(&self) -> u64 {
        self.camera_angles_deg.len().max(1) as u64
    }

    /// The scene of a sequence, and the camera in it.
    pub fn scene_of(&self, sequence: u64) -> (u64, u64) {
        (sequence / self.cameras(), sequence % self.cameras())
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
