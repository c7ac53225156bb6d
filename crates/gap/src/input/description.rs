//! `scene.json`: description of a scene beside its frames.
//!
//! | field | meaning | unit |
//! |---|---|---|
//! | `width`, `height` | the sensor | pixels |
//! | `fps` | frame i is at time i / fps | frames per second |
//! | `duration_s` | length of the recording | seconds |
//! | `white` | the value of white in the frames; optional | |
//! | `nominal` | nominal values of the sensor, see [`Nominal`]; optional | |

use std::path::Path;

use evpose_core::{SensorSize, without_bom};
use serde_json::{Map, Value};

use crate::GapError;

/// The fields of `scene.json`.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// Size of the sensor.
    pub size: SensorSize,
    /// Frames per second.
    pub fps: f64,
    /// Length of the recording in seconds.
    pub duration_s: f64,
    /// Value of white in the frames.
    pub white: Option<f64>,
    /// Nominal values of the sensor.
    pub nominal: Option<Nominal>,
    /// Names of unknown fields.
    pub unknown: Vec<String>,
}

/// Nominal values of the sensor, as given with a recording. Missing ones are as in the model.
///
/// | field | of | unit |
/// |---|---|---|
/// | `C_on`, `C_off` | thresholds | ln |
/// | `sigma_C` | spread of the thresholds over pixels | ln |
/// | `noise_on_hz`, `noise_off_hz` | noise events of a pixel | Hz |
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Nominal {
    /// Threshold of ON events, ln.
    pub threshold_on: Option<f64>,
    /// Threshold of OFF events, ln.
    pub threshold_off: Option<f64>,
    /// Standard deviation of thresholds over pixels, ln.
    pub threshold_sigma: Option<f64>,
    /// ON noise events of a pixel per second.
    pub noise_on_hz: Option<f64>,
    /// OFF noise events of a pixel per second.
    pub noise_off_hz: Option<f64>,
}

const KNOWN: [&str; 6] = ["width", "height", "fps", "duration_s", "white", "nominal"];
const NOMINAL: [&str; 5] = ["C_on", "C_off", "sigma_C", "noise_on_hz", "noise_off_hz"];

#[derive(Clone, Copy)]
enum Range {
    Positive,
    NotNegative,
}

impl Description {
    /// Reads a `scene.json`.
    ///
    /// # Errors
    /// A file that cannot be read or is no JSON object, and a field that is missing or invalid.
    pub fn read(path: &Path) -> Result<Self, GapError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| GapError::File { path: path.to_owned(), source })?;
        let object = match serde_json::from_str(without_bom(&text)) {
            Ok(Value::Object(object)) => object,
            Ok(_) => return Err(GapError::json(path, "expected an object, { … }")),
            Err(e) => return Err(GapError::json(path, e.to_string())),
        };
        Fields { path, parent: "", object: &object }.description()
    }
}

/// The fields of a JSON object, with the path for messages.
struct Fields<'a> {
    path: &'a Path,
    parent: &'a str,
    object: &'a Map<String, Value>,
}

impl Fields<'_> {
    fn description(&self) -> Result<Description, GapError> {
        let size = SensorSize { width: self.pixels("width")?, height: self.pixels("height")? };
        let fps = self.number("fps", Range::Positive)?;
        let duration_s = self.number("duration_s", Range::Positive)?;
        let white = self.optional("white", Range::Positive)?;
        let nominal = match self.object.get("nominal") {
            None | Some(Value::Null) => None,
            Some(Value::Object(object)) => {
                Some(Fields { path: self.path, parent: "nominal.", object }.nominal()?)
            }
            Some(other) => return Err(self.wrong_value("nominal", "an object, { … }", other)),
        };
        let unknown = self.object.keys().filter(|key| !KNOWN.contains(&key.as_str()));
        let unknown = unknown.cloned().collect();
        Ok(Description { size, fps, duration_s, white, nominal, unknown })
    }

    fn nominal(&self) -> Result<Nominal, GapError> {
        // A misspelt name must not be ignored in silence.
        if let Some(key) = self.object.keys().find(|key| !NOMINAL.contains(&key.as_str())) {
            let known = NOMINAL.join(", ");
            return Err(self.fault(key, format!("unknown; there are {known}")));
        }
        Ok(Nominal {
            threshold_on: self.optional("C_on", Range::Positive)?,
            threshold_off: self.optional("C_off", Range::Positive)?,
            threshold_sigma: self.optional("sigma_C", Range::NotNegative)?,
            noise_on_hz: self.optional("noise_on_hz", Range::NotNegative)?,
            noise_off_hz: self.optional("noise_off_hz", Range::NotNegative)?,
        })
    }

    fn pixels(&self, field: &str) -> Result<u16, GapError> {
        let number = self.number(field, Range::Positive)?;
        let whole = number.fract() == 0.0 && number <= f64::from(u16::MAX);
        let value = &self.object[field];
        if whole {
            Ok(number as u16)
        } else {
            Err(self.wrong_value(field, "1 to 65535 pixels", value))
        }
    }

    fn number(&self, field: &str, range: Range) -> Result<f64, GapError> {
        let missing = || self.fault(field, "missing".to_owned());
        self.optional(field, range)?.ok_or_else(missing)
    }

    fn optional(&self, field: &str, range: Range) -> Result<Option<f64>, GapError> {
        let value = match self.object.get(field) {
            None | Some(Value::Null) => return Ok(None),
            Some(value) => value,
        };
        let (expected, min) = match range {
            Range::Positive => ("a positive number", f64::MIN_POSITIVE),
            Range::NotNegative => ("a number not below zero", 0.0),
        };
        match value.as_f64().filter(|number| *number >= min) {
            Some(number) => Ok(Some(number)),
            None => Err(self.wrong_value(field, expected, value)),
        }
    }

    fn wrong_value(&self, field: &str, expected: &str, value: &Value) -> GapError {
        self.fault(field, format!("expected {expected}, found {value}"))
    }

    fn fault(&self, field: &str, problem: String) -> GapError {
        let field = format!("{}{field}", self.parent);
        GapError::Field { path: self.path.to_owned(), field, problem }
    }
}
