//! Simulation of a sensor model on a scene.

use evpose_core::EventStream;
use evpose_sensor::{SensorConfig, SensorModel};

use crate::{Classes, Expected, GapError, LightSequence, ReferenceScene};

impl LightSequence {
    /// Simulates the events of a sensor on the scene.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn events(&self, config: &SensorConfig, seed: u64) -> Result<EventStream, GapError> {
        let all = self.events_up_to(config, seed, usize::MAX)?;
        Ok(all.unwrap_or_else(|| EventStream::empty(self.size())))
    }

    /// As [`Self::events`], or none as soon as there are more than `max_events`.
    fn events_up_to(
        &self,
        config: &SensorConfig,
        seed: u64,
        max_events: usize,
    ) -> Result<Option<EventStream>, GapError> {
        // Light behind the optics is kept: they are slow, and most models share them.
        let behind = self.behind_optics(config)?;
        let (planes, model) = match &behind {
            Some(divided) => (divided.light.as_slice(), &divided.rest),
            None => (self.planes(), config),
        };
        let mut run = SensorModel::from_config(model)?.start(self.size(), seed);
        let mut all = EventStream::empty(self.size());
        for (k, plane) in planes.iter().enumerate() {
            for event in run.expose(plane, self.time(k))?.iter().filter(|e| self.is_compared(e)) {
                all.push(event).map_err(|error| {
                    GapError::Recording(format!("{error}\n{}", config.to_toml()))
                })?;
            }
            // After each frame: a model with too much noise would fill the memory before the end.
            if all.len() > max_events {
                return Ok(None);
            }
        }
        Ok(Some(all))
    }
}

impl ReferenceScene {
    /// Computes the classes of a scene and its reference events: those of `reference`, the sensor
    /// without noise and delays.
    ///
    /// # Errors
    /// A reference that cannot be built or shown the scene.
    pub fn new(scene: LightSequence, reference: &SensorConfig) -> Result<Self, GapError> {
        let classes = Classes::from_scene(&scene);
        let mut reference_scene = Self { scene, classes, expected: Expected::default() };
        reference_scene.expected = Expected::from_events(&reference_scene.simulate(reference, 0)?);
        Ok(reference_scene)
    }

    /// Simulates the events of a sensor on the scene.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn simulate(&self, config: &SensorConfig, seed: u64) -> Result<EventStream, GapError> {
        self.scene.events(config, seed)
    }

    /// As [`Self::simulate`], or none as soon as there are more than `max_events`.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn simulate_up_to(
        &self,
        config: &SensorConfig,
        seed: u64,
        max_events: usize,
    ) -> Result<Option<EventStream>, GapError> {
        self.scene.events_up_to(config, seed, max_events)
    }
}
