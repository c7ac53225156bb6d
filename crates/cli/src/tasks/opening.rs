//! Arguments of opening a recording, and the size of its sensor.
//!
//! The size is the one that the file states, or else that of the file beside it, of `--sensor`, or
//! the smallest that holds every event, which is said. Sizes that contradict each other are errors.

use std::path::Path;

use crate::progress::note;
use crate::ranges::within;
use crate::sidecar::sensor_beside;
use anyhow::{Result, bail};
use evpose_core::SensorSize;
use evpose_io::{ColumnNames, OpenOptions, Restarts, SensorOrigin, TimeUnit, find_sensor};

/// Properties of a recording that its file may not state.
#[derive(Debug, Default, clap::Args)]
pub struct OpeningArgs {
    /// Sensor size, for files that do not state it, for example 346x260
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub sensor: Option<SensorSize>,
    /// Camera of a file that holds several, counted from 0
    #[arg(long, value_name = "INDEX")]
    pub camera_index: Option<u8>,
    /// Microseconds per tick of YARP's clock: 0.08 or 1
    #[arg(long, value_name = "MICROSECONDS", value_parser = within(1e-3..=1e6))]
    pub tick_us: Option<f64>,
    /// Read the intact parts of a damaged file, and report what is lost
    #[arg(long)]
    pub salvage: bool,
    /// Of a recording whose clock starts again within the file: only this part, counted from 1
    #[arg(long, value_name = "N", conflicts_with_all = ["join", "sort"],
          value_parser = clap::value_parser!(u32).range(1..))]
    pub part: Option<u32>,
    /// All parts, one after the other in time
    #[arg(long, conflicts_with = "sort")]
    pub join: bool,
    /// All events by their time stamps, whatever their order; takes the memory of the whole recording
    #[arg(long)]
    pub sort: bool,
    /// Unit of times in tables and arrays that do not state it: s, ms, us or ns
    #[arg(long, value_name = "UNIT")]
    pub time_unit: Option<TimeUnit>,
    /// Columns of tables and arrays by their names, or by their indices from 0 on, for example
    /// t=stamp,x=u,y=v,p=sign
    #[arg(long, value_name = "t=NAME,...")]
    pub columns: Option<ColumnNames>,
    /// Exchange rows and columns of pixels
    #[arg(long)]
    pub swap_xy: bool,
    /// Shift time stamps so that the first event, or the time of --from, is at 0
    #[arg(long)]
    pub zero_time: bool,
    /// Topic of the events, of a recording of ROS that holds several
    #[arg(long, value_name = "NAME")]
    pub topic: Option<String>,
}

impl OpeningArgs {
    /// The options as they are written behind a command, each after a space.
    pub fn words(&self) -> String {
        let of = |flag: &str, value: Option<String>| {
            value.map_or_else(String::new, |value| format!(" --{flag} {value}"))
        };
        let mark = |flag: &str, is_on: bool| match is_on {
            true => format!(" --{flag}"),
            false => String::new(),
        };
        [
            of("sensor", self.sensor.map(|size| size.to_string())),
            of("camera-index", self.camera_index.map(|index| index.to_string())),
            of("tick-us", self.tick_us.map(|tick| tick.to_string())),
            mark("salvage", self.salvage),
            of("part", self.part.map(|part| part.to_string())),
            mark("join", self.join),
            mark("sort", self.sort),
            of("time-unit", self.time_unit.map(|unit| unit.to_string())),
            of("columns", self.columns.as_ref().map(ColumnNames::to_string)),
            mark("swap-xy", self.swap_xy),
            mark("zero-time", self.zero_time),
            of("topic", self.topic.clone()),
        ]
        .concat()
    }

    /// Options of opening `recording`, with the sensor of `--sensor` or of the file beside it.
    ///
    /// # Errors
    /// If `--sensor` contradicts the recording or the file beside it.
    pub fn options(&self, recording: &Path) -> Result<OpenOptions> {
        let beside = sensor_beside(recording);
        if let (Some(given), Some((path, sensor))) = (self.sensor, &beside)
            && given != *sensor
        {
            bail!("--sensor {given}: {} states a sensor of {sensor}", path.display());
        }
        let options = OpenOptions {
            sensor: self.sensor.or(beside.map(|(_, sensor)| sensor)),
            camera: self.camera_index,
            tick_us: self.tick_us,
            salvage: self.salvage,
            restarts: match (self.part, self.join, self.sort) {
                (Some(part), ..) => Restarts::Part(part as usize),
                (None, true, _) => Restarts::Join,
                (None, false, true) => Restarts::Sort,
                (None, false, false) => Restarts::Refuse,
            },
            time_unit: self.time_unit,
            columns: self.columns.clone().unwrap_or_default(),
            swap_xy: self.swap_xy,
            zero_time: self.zero_time,
            topic: self.topic.clone(),
        };
        // For its errors alone: the recording may state another sensor.
        if self.sensor.is_some() && recording.exists() {
            find_sensor(recording, &options)?;
        }
        Ok(options)
    }

    /// As [`Self::options`], with the size of the sensor in any case; a note says where it is a
    /// guess.
    ///
    /// # Errors
    /// If the recording cannot be read, or sizes of its sensor contradict each other.
    pub fn options_with_sensor(&self, recording: &Path) -> Result<OpenOptions> {
        let options = self.options(recording)?;
        let (sensor, origin) = find_sensor(recording, &options)?;
        let path = recording.display();
        match origin {
            SensorOrigin::Stated | SensorOrigin::Given => {}
            SensorOrigin::Assumed => note(format!(
                "note: {path} does not state its sensor: {sensor} is usual for its format; set it \
                 with --sensor"
            )),
            SensorOrigin::Inferred => note(format!(
                "note: {path} does not state its sensor: {sensor} is the smallest that holds every \
                 event; set it with --sensor"
            )),
        }
        Ok(OpenOptions { sensor: Some(sensor), ..options })
    }
}

/// Parses a size such as 346x260.
///
/// # Errors
/// If the text is no such size.
pub fn parse_size(text: &str) -> Result<SensorSize> {
    let pixels = |text: &str| text.parse().ok().filter(|&n: &u16| n > 0);
    let Some((width, height)) = text.split_once('x') else {
        bail!("expected WIDTHxHEIGHT, for example 346x260");
    };
    let Some(width) = pixels(width) else { bail!("the width is an integer from 1 to 65535") };
    let Some(height) = pixels(height) else { bail!("the height is an integer from 1 to 65535") };
    Ok(SensorSize { width, height })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_is_of_the_file_then_of_the_file_beside_it_then_as_given_then_inferred() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("plain.txt"), "0.0 3 4 1\n0.1 20 9 0\n").unwrap();
        let given = |sensor| OpeningArgs { sensor, ..OpeningArgs::default() };
        let size = |width, height| Some(SensorSize { width, height });
        let found = |name: &str, sensor| {
            given(sensor).options_with_sensor(&path(name)).map(|options| options.sensor)
        };
        assert_eq!(found("plain.txt", None).unwrap(), size(21, 10));
        assert_eq!(found("plain.txt", size(32, 24)).unwrap(), size(32, 24));
        let error = found("plain.txt", size(16, 24)).unwrap_err().to_string();
        assert!(error.contains("plain.txt") && error.contains("21x10"), "{error}");

        std::fs::write(path("plain.toml"), "[sensor]\nwidth = 64\nheight = 48\n").unwrap();
        assert_eq!(found("plain.txt", None).unwrap(), size(64, 48));
        let error = found("plain.txt", size(32, 24)).unwrap_err().to_string();
        assert!(error.contains("plain.toml") && error.contains("64x48"), "{error}");

        std::fs::write(path("stated.txt"), "40 30\n0 3 4 1\n").unwrap();
        assert_eq!(found("stated.txt", None).unwrap(), size(40, 30));
        let error = given(size(32, 24)).options(&path("stated.txt")).unwrap_err().to_string();
        assert!(error.contains("stated.txt") && error.contains("40x30"), "{error}");
    }
}
