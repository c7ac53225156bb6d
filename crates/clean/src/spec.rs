//! The entry of a cleaner in the registry.

use evpose_core::SensorSize;

use crate::{CleanError, Cleaner, CleanerParamSpec, CleanerSettings};

/// Makes a cleaner from checked settings, for events of a sensor.
pub type Build = fn(&CleanerSettings, SensorSize) -> Result<Box<dyn Cleaner>, CleanError>;

/// A cleaner as the registry lists it: name, parameters and constructor.
#[derive(Debug)]
pub struct CleanerSpec {
    /// Name in requests.
    pub name: &'static str,
    /// One line on its effect.
    pub summary: &'static str,
    /// Parameters that it takes.
    pub params: &'static [CleanerParamSpec],
    /// Whether events may leave it at other pixels than they came.
    pub displaces: bool,
    /// Makes it for events of a sensor.
    pub build: Build,
}

impl CleanerSpec {
    /// The parameter of this name.
    pub fn param(&self, name: &str) -> Option<&'static CleanerParamSpec> {
        self.params.iter().find(|param| param.name == name)
    }
}
