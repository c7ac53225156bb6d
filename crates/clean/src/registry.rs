//! Every cleaner, by name.

use std::str::FromStr;

use evpose_core::{Given, Registry, SensorSize, Settings, registry_entry};

use crate::{CleanError, Cleaner, CleanerSpec};
use crate::{background, deflicker, hot, masking, undistort};

/// All cleaners, in the order of tables and help texts; those of other crates come last.
pub static CLEANERS: Registry<CleanerSpec> = Registry::new(&[
    &hot::SPEC,
    &masking::SPEC,
    &background::SPEC,
    &deflicker::SPEC,
    &undistort::SPEC,
]);

registry_entry!(CleanerSpec, "cleaner");

/// The cleaner of this name.
///
/// # Errors
/// If there is none; the message lists those there are.
pub fn cleaner_by_name(name: &str) -> Result<&'static CleanerSpec, CleanError> {
    CLEANERS.find(name).ok_or_else(|| CleanError::UnknownCleaner {
        name: name.to_owned(),
        known: CLEANERS.names(),
    })
}

/// A cleaner that is asked for, with its parameters: written `name:key=value,key=value`.
#[derive(Debug, Clone)]
pub struct CleanRequest {
    spec: &'static CleanerSpec,
    settings: Settings,
}

impl CleanRequest {
    /// The name of the cleaner.
    pub fn name(&self) -> &'static str {
        self.spec.name
    }

    /// Makes the cleaner.
    ///
    /// # Errors
    /// Parameters that do not go together or with `sensor`, and files that cannot be read.
    pub fn build(&self, sensor: SensorSize) -> Result<Box<dyn Cleaner>, CleanError> {
        (self.spec.build)(&self.settings, sensor)
    }
}

impl FromStr for CleanRequest {
    type Err = CleanError;

    fn from_str(text: &str) -> Result<Self, CleanError> {
        let (name, rest) = text.split_once(':').unwrap_or((text, ""));
        let spec = cleaner_by_name(name)?;
        // A request without parameters, or with a trailing comma, has an empty part.
        let parts = rest.split(',').filter(|part| !part.is_empty());
        let given: Result<Vec<_>, CleanError> = parts
            .map(|part| {
                let bad = || CleanError::BadRequest(text.to_owned());
                let (key, value) = part.split_once('=').ok_or_else(bad)?;
                Ok((key.trim(), Given::Text(value.trim())))
            })
            .collect();
        let settings = Settings::resolve(spec.params, &given?);
        let refused = |error| CleanError::Parameter { cleaner: spec.name, error };
        Ok(Self { spec, settings: settings.map_err(refused)? })
    }
}
