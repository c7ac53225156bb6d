//! The entry of a cleaner in the registry.

use evpose_core::{Parameter, SensorSize, Settings};

use crate::{CleanError, Cleaner};

/// Makes a cleaner from checked settings, for events of a sensor.
pub type Build = fn(&Settings, SensorSize) -> Result<Box<dyn Cleaner>, CleanError>;

/// A cleaner as the registry lists it: name, parameters and constructor.
#[derive(Debug)]
pub struct CleanerSpec {
    /// Name in requests.
    pub name: &'static str,
    /// One line on its effect.
    pub summary: &'static str,
    /// Parameters that it takes.
    pub params: &'static [Parameter],
    /// Whether events may leave it at other pixels than they came.
    pub displaces: bool,
    /// Makes it for events of a sensor.
    pub build: Build,
}

impl CleanerSpec {
    /// Refuses what else was given beside `param`, which sets everything.
    pub(crate) fn alone(&self, settings: &Settings, param: &Parameter) -> Result<(), CleanError> {
        let (cleaner, key) = (self.name, param.name());
        match settings.given().find(|name| *name != key) {
            Some(other) => Err(CleanError::Conflict { cleaner, key, other }),
            None => Ok(()),
        }
    }
}
