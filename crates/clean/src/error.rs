//! Errors of requests, files and events.

use std::io;
use std::path::PathBuf;

use evpose_camera::CalibrationError;
use evpose_core::{Micros, ParameterError, SensorSize};

/// Why a recording cannot be cleaned as asked.
#[derive(Debug, thiserror::Error)]
pub enum CleanError {
    /// No cleaner has this name.
    #[error(
        "no cleaner is called `{name}`; there are {}",
        known.join(", ")
    )]
    UnknownCleaner {
        /// Name that was asked for.
        name: String,
        /// The names of the registry.
        known: Vec<&'static str>,
    },
    /// A parameter that the cleaner does not have, or a value that one does not take.
    #[error("{}", of_cleaner(cleaner, error))]
    Parameter {
        /// Name of the cleaner.
        cleaner: &'static str,
        /// Name of the parameter, and why it is refused.
        error: ParameterError,
    },
    /// A request is not `name` or `name:key=value,key=value`.
    #[error("{0:?} is not written as `name:key=value,key=value`")]
    BadRequest(String),
    /// One of several parameters must be given.
    #[error("`{cleaner}` needs {needs}")]
    Missing {
        /// Name of the cleaner.
        cleaner: &'static str,
        /// The missing parameters.
        needs: &'static str,
    },
    /// Two parameters that cannot go together.
    #[error("`{cleaner}` takes `{key}` or `{other}`, not both")]
    Conflict {
        /// Name of the cleaner.
        cleaner: &'static str,
        /// One parameter.
        key: &'static str,
        /// Parameter that excludes it.
        other: &'static str,
    },
    /// A file or a preset is for another sensor.
    #[error("{what} is for a {actual} sensor, the events come from one of {sensor}")]
    OtherSensor {
        /// The file or preset.
        what: String,
        /// Sensor that the file or preset is for.
        actual: SensorSize,
        /// That of the events.
        sensor: SensorSize,
    },
    /// Events of a sensor that the cleaners were not made for.
    #[error("events of a {actual} sensor, the cleaners are made for one of {sensor}")]
    EventsOfOtherSensor {
        /// That of the events.
        actual: SensorSize,
        /// That of the cleaners.
        sensor: SensorSize,
    },
    /// A batch starts before the last one ended.
    #[error("events start at {t}, before the last ones, which end at {previous}")]
    OutOfOrder {
        /// First time of the batch.
        t: Micros,
        /// Last time before it.
        previous: Micros,
    },
    /// A cleaner that has to see the whole recording first has not.
    #[error("`{cleaner}` must see the whole recording before it cleans")]
    NotSurveyed {
        /// Name of the cleaner.
        cleaner: &'static str,
    },
    /// The file of a camera cannot be read.
    #[error(transparent)]
    Camera(#[from] CalibrationError),
    /// A file cannot be read or written.
    #[error("{}: {error}", path.display())]
    File {
        /// File that was refused.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
    /// A file holds something else than it should.
    #[error("{}: {reason}", path.display())]
    BadFile {
        /// File with the wrong content.
        path: PathBuf,
        /// Description of the wrong content.
        reason: String,
    },
}

fn of_cleaner(cleaner: &str, error: &ParameterError) -> String {
    match error {
        ParameterError::BadValue { parameter, value } => {
            let (key, expected) = (parameter.name(), parameter.expected());
            format!("`{key}` of `{cleaner}` is {value:?}, expected {expected}")
        }
        _ => format!("`{cleaner}` {error}"),
    }
}
