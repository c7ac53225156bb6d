//! The format of the events of a run.

use std::path::Path;

use evpose_core::{EventStream, SensorSize};
use evpose_io::{EvcWriter, EventSink, FORMATS, Format, writable_format};

use crate::config::SimulationConfig;
use crate::person::PeopleConfig;
use crate::{SimError, with_ending};

/// Rows of the tallest sensor that an `.evc` file holds.
const MAX_EVC_ROWS: u16 = 256;
/// Name of the format of EventHands.
const EVC: &str = "evc";
/// Ending of what is written unless a config says otherwise, of sensors of any size: EVT3.
const RAW: &str = "raw";

/// A format that events are written in.
#[derive(Debug, Clone, Copy)]
pub struct EventFormat {
    format: &'static Format,
    ending: &'static str,
}

impl EventFormat {
    /// The format of `simulation.format`: the name of a format, or an ending such as `raw`.
    ///
    /// # Errors
    /// If no format that can be written has this name, or it cannot hold events of `sensor`.
    pub fn by_name(name: &str, sensor: SensorSize) -> Result<Self, SimError> {
        let Some((format, ending)) = writable_format(name) else {
            let writable = FORMATS.iter().filter(|format| format.create.is_some());
            let known = writable.map(|format| format.name).collect();
            return Err(SimError::UnknownFormat { name: name.to_owned(), known });
        };
        // Refused here: the first event beyond row 255 would come hours into a run.
        if format.name == EVC && sensor.height > MAX_EVC_ROWS {
            return Err(SimError::Config {
                field: "format",
                value: format!("{EVC} of {sensor}"),
                reason: "evc holds sensors of up to 256 rows: choose another, such as raw or h5",
            });
        }
        Ok(Self { format, ending: ending.trim_start_matches('.') })
    }

    /// That of hands: as the config says, else `.evc` where it holds the sensor, else `.raw`.
    ///
    /// # Errors
    /// As [`Self::by_name`].
    pub fn of_hands(config: &SimulationConfig) -> Result<Self, SimError> {
        let sensor = config.image_size();
        let usual = if sensor.height > MAX_EVC_ROWS { RAW } else { EVC };
        Self::by_name(config.format.as_deref().unwrap_or(usual), sensor)
    }

    /// That of people: as the config says, else `.raw`.
    ///
    /// # Errors
    /// As [`Self::by_name`].
    pub fn of_people(config: &PeopleConfig) -> Result<Self, SimError> {
        Self::by_name(config.format.as_deref().unwrap_or(RAW), config.sensor_size)
    }

    /// Ending of its files, without a dot.
    pub fn ending(&self) -> &'static str {
        self.ending
    }
}

/// Writes the events of a sequence step by step.
///
/// An `.evc` file has a frame for each step, whatever the time stamps of its events. In every other
/// format events keep their time stamps.
pub struct StepWriter(Destination);

enum Destination {
    Frames(EvcWriter),
    Stream(Box<dyn EventSink>, u64),
}

impl StepWriter {
    /// Begins `STEM.ENDING`, which appears under its name on [`Self::finish`].
    ///
    /// # Errors
    /// If the file cannot be created, or the format does not hold the sensor.
    pub fn create(stem: &Path, format: EventFormat, sensor: SensorSize) -> Result<Self, SimError> {
        let path = with_ending(stem, format.ending);
        Ok(Self(if format.format.name == EVC {
            Destination::Frames(EvcWriter::create(&path, sensor)?)
        } else {
            Destination::Stream(format.format.create(&path, sensor)?, 0)
        }))
    }

    /// Appends the events of the next step, whose times are not before those of the step before.
    ///
    /// # Errors
    /// If the disk is full, or an event does not fit the format.
    pub fn step(&mut self, events: &EventStream) -> Result<(), SimError> {
        match &mut self.0 {
            Destination::Frames(file) => file.frame(events)?,
            Destination::Stream(file, count) => {
                file.write(events)?;
                *count += events.len() as u64;
            }
        }
        Ok(())
    }

    /// Number of events written so far.
    pub fn events(&self) -> u64 {
        match &self.0 {
            Destination::Frames(file) => file.events(),
            Destination::Stream(_, count) => *count,
        }
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// If it cannot be finished.
    pub fn finish(self) -> Result<(), SimError> {
        match self.0 {
            Destination::Frames(file) => file.finish()?,
            Destination::Stream(file, _) => file.finish()?,
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(width: u16, height: u16, format: Option<&str>) -> Result<&'static str, String> {
        let config = SimulationConfig {
            sensor_size: SensorSize { width, height },
            format: format.map(str::to_owned),
            ..SimulationConfig::default()
        };
        EventFormat::of_hands(&config).map(|format| format.ending()).map_err(|e| e.to_string())
    }

    #[test]
    fn hands_are_evc_unless_the_sensor_is_too_tall_or_the_config_says_otherwise() {
        assert_eq!(of(240, 180, None).unwrap(), "evc");
        assert_eq!(of(346, 256, None).unwrap(), "evc");
        assert_eq!(of(346, 260, None).unwrap(), "raw");
        assert_eq!(of(1280, 720, Some("npz")).unwrap(), "npz");
        assert_eq!(of(128, 128, Some("aedat4")).unwrap(), "aedat4");
        let message = of(346, 260, Some("evc")).unwrap_err();
        assert!(message.contains("evc of 346x260") && message.contains("256 rows"), "{message}");
        let message = of(346, 260, Some("mp4")).unwrap_err();
        assert!(message.contains("`mp4`") && message.contains("evt3, "), "{message}");
        let people = EventFormat::of_people(&PeopleConfig::default()).unwrap();
        assert_eq!(people.ending(), "raw");
    }
}
