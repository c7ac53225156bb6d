//! Validation of a configuration, with messages that name field, value and constraint.

use super::{BackgroundSource, LightConfig, SimulationConfig, SkinSource};
use crate::SimError;

/// Largest side of an image: event cameras of 2026 have at most 1280 columns.
const MAX_SIDE_PX: f32 = 4_096.0;
/// Largest step count of one movement or rest: almost three hours at 1 kHz.
const MAX_MOTION_STEPS: f64 = 1e7;

impl SimulationConfig {
    /// Checks every field.
    ///
    /// # Errors
    /// The first field that makes no sense, and a sensor that cannot be built.
    pub fn validate(&self) -> Result<(), SimError> {
        self.check_times()?;
        self.check_image()?;
        self.check_appearance()?;
        self.check_skin()?;
        check_from("threshold_sd", self.threshold_sd, 0.0)?;
        crate::EventFormat::of_hands(self)?;
        evpose_sensor::SensorModel::from_config(&self.sensor.resolve()?)?;
        Ok(())
    }

    fn check_times(&self) -> Result<(), SimError> {
        check("sequences", &self.sequences, self.sequences > 0, "must be at least 1")?;
        check_positive("seconds", self.seconds)?;
        let whole = self.step_hz > 0 && 1_000_000 % self.step_hz == 0;
        check(
            "step_hz",
            &self.step_hz,
            whole,
            "must divide a million: steps are whole microseconds",
        )?;
        check_positive("episode_s", self.episode_s)?;
        let motion = self.motion;
        let steps = motion.period_s * f64::from(self.step_hz);
        check(
            "motion.period_s",
            &motion.period_s,
            (1.0..=MAX_MOTION_STEPS).contains(&steps),
            "must be at least one step and at most 10 million",
        )?;
        check(
            "motion.pause_s",
            &motion.pause_s,
            (0.0..=MAX_MOTION_STEPS).contains(&(motion.pause_s * f64::from(self.step_hz))),
            "must be from 0 to 10 million steps",
        )?;
        check(
            "motion.stay_probability",
            &motion.stay_probability,
            (0.0..1.0).contains(&motion.stay_probability),
            "must be from 0 to less than 1",
        )?;
        let ranges = motion.articulation_low.iter().zip(&motion.articulation_high);
        check(
            "motion.articulation_low",
            &format!("{:?}", motion.articulation_low),
            ranges
                .into_iter()
                .all(|(low, high)| low <= high && low.is_finite() && high.is_finite()),
            "must be at most motion.articulation_high",
        )?;
        check("seconds", &self.seconds, self.frames() > 0, "must be at least one step")?;
        check("episode_s", &self.episode_s, self.episode_frames() > 0, "must be at least one step")
    }

    fn check_image(&self) -> Result<(), SimError> {
        let sides = [self.sensor_size.width, self.sensor_size.height].map(f32::from);
        check_positive("image_scale", f64::from(self.image_scale))?;
        let fits = |side: f32| (1.0..=MAX_SIDE_PX).contains(&(side * self.image_scale).round());
        check(
            "image_scale",
            &format!("{} of {}", self.image_scale, self.sensor_size),
            sides.into_iter().all(fits),
            "the image must have 1 to 4096 pixels along each side",
        )?;
        let camera = self.camera;
        let fov_deg = camera.vertical_fov_deg;
        check(
            "camera.vertical_fov_deg",
            &fov_deg,
            0.0 < fov_deg && fov_deg < 180.0,
            "must lie between 0 and 180",
        )?;
        check_positive("camera.near_m", f64::from(camera.near_m))?;
        // The cross product is the right-hand axis of the image, which has to be a direction.
        let across = (camera.centre_m - camera.eye_m).cross(camera.up).length();
        check(
            "camera.up",
            &camera.up,
            across.is_finite() && across > 1e-6,
            "must not be parallel to the line from eye_m to centre_m, which must differ",
        )
    }

    /// A skin texture fits only the texture coordinates of its own model.
    fn check_skin(&self) -> Result<(), SimError> {
        let is_painted_for = match self.skin.source {
            SkinSource::Procedural => self.body.uvs.is_none(),
            SkinSource::Html(_) => self.body.uvs.is_some(),
        };
        check(
            "body.uvs",
            &self.body.uvs.as_ref().map_or_else(String::new, |path| path.display().to_string()),
            is_painted_for,
            "skin.source = { html = … } needs the texture coordinates of its model; a made-up skin has its own",
        )
    }

    fn check_appearance(&self) -> Result<(), SimError> {
        check_from("shape_range", f64::from(self.shape_range), 0.0)?;
        check_from("light_level", f64::from(self.light_level), 0.0)?;
        self.lights.validate()?;
        let backgrounds = &self.backgrounds;
        if let BackgroundSource::Procedural(count) = backgrounds.source {
            check("backgrounds.source.procedural", &count, count > 0, "must be at least 1")?;
        }
        check_positive("backgrounds.scale", f64::from(backgrounds.scale))?;
        check_from("backgrounds.offset", f64::from(backgrounds.offset), 0.0)?;
        check_positive("backgrounds.gamma", f64::from(backgrounds.gamma))?;
        let texels = self.skin.texels;
        // Spots of a skin are of a tenth of its side.
        check("skin.texels", &texels, (10..=4_096).contains(&texels), "must be 10 to 4096")?;
        check_from("skin.variation_sd", f64::from(self.skin.variation_sd), 0.0)
    }
}

impl LightConfig {
    pub(crate) fn validate(&self) -> Result<(), SimError> {
        for (field, colour) in [
            ("lights.first", self.first),
            ("lights.second", self.second),
            ("lights.ambient", self.ambient),
        ] {
            let lit = colour.is_finite() && colour.min_element() >= 0.0;
            check(field, &colour, lit, "must be three values from 0")?;
        }
        check_from("lights.gain", f64::from(self.gain), 0.0)?;
        let [low, high] = self.jitter;
        check(
            "lights.jitter",
            &format!("[{low}, {high}]"),
            0.0 <= low && low <= high && high.is_finite(),
            "must be a range [low, high] with 0 <= low <= high",
        )
    }
}

fn check(
    field: &'static str,
    value: &impl ToString,
    holds: bool,
    reason: &'static str,
) -> Result<(), SimError> {
    if holds { Ok(()) } else { Err(SimError::Config { field, value: value.to_string(), reason }) }
}

fn check_positive(field: &'static str, value: f64) -> Result<(), SimError> {
    check(field, &value, value > 0.0 && value.is_finite(), "must be greater than 0")
}

fn check_from(field: &'static str, value: f64, min: f64) -> Result<(), SimError> {
    check(field, &value, value >= min && value.is_finite(), "must be at least 0")
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn complaint(change: impl FnOnce(&mut SimulationConfig)) -> String {
        let mut config = SimulationConfig::default();
        change(&mut config);
        config.validate().unwrap_err().to_string()
    }

    #[test]
    fn the_published_setting_is_valid() {
        SimulationConfig::default().validate().unwrap();
    }

    #[test]
    fn a_complaint_names_the_field_its_value_and_what_is_wrong() {
        assert_eq!(
            complaint(|c| c.seconds = -1.0),
            "simulation.seconds = -1: must be greater than 0"
        );
        assert_eq!(
            complaint(|c| c.step_hz = 333),
            "simulation.step_hz = 333: must divide a million: steps are whole microseconds"
        );
        assert_eq!(
            complaint(|c| c.image_scale = 0.001),
            "simulation.image_scale = 0.001 of 240x180: \
             the image must have 1 to 4096 pixels along each side"
        );
        assert_eq!(
            complaint(|c| c.lights.jitter = [1.2, 1.1]),
            "simulation.lights.jitter = [1.2, 1.1]: \
             must be a range [low, high] with 0 <= low <= high"
        );
        assert_eq!(
            complaint(|c| c.backgrounds.source = BackgroundSource::Procedural(0)),
            "simulation.backgrounds.source.procedural = 0: must be at least 1"
        );
        assert!(complaint(|c| c.light_level = -0.1).starts_with("simulation.light_level = -0.1"));
        assert!(complaint(|c| c.motion.period_s = 0.0).starts_with("simulation.motion.period_s"));
        assert!(complaint(|c| c.motion.pause_s = -1.0).starts_with("simulation.motion.pause_s"));
        assert!(complaint(|c| c.camera.up = Vec3::ZERO).starts_with("simulation.camera.up = "));
        assert!(complaint(|c| c.seconds = f64::NAN).starts_with("simulation.seconds = NaN"));
    }

    #[test]
    fn unknown_fields_are_refused_by_name() {
        let error = SimulationConfig::from_toml("secs = 3").unwrap_err().to_string();
        assert!(error.contains("unknown field `secs`"), "{error}");
        let error = SimulationConfig::from_toml("[lights]\nglow = 3").unwrap_err().to_string();
        assert!(error.contains("unknown field `glow`"), "{error}");
        let error = SimulationConfig::from_toml("sensor = \"eye\"").unwrap_err().to_string();
        assert!(error.contains("eye"), "{error}");
    }

    #[test]
    fn a_configuration_survives_being_written() {
        let text = r#"
            image_scale = 0.5
            backgrounds.source = { folder = "images" }
            [[sensor.effect]]
            name = "level_crossing"
            threshold_on = 0.2
            threshold_off = 0.2
        "#;
        let config = SimulationConfig::from_toml(text).unwrap();
        let written = toml::to_string(&config).unwrap();
        assert_eq!(SimulationConfig::from_toml(&written).unwrap(), config);
        assert_eq!(config.image_size().to_string(), "120x90");
        let written = toml::to_string(&SimulationConfig::default()).unwrap();
        assert_eq!(SimulationConfig::from_toml(&written).unwrap(), SimulationConfig::default());
    }
}
