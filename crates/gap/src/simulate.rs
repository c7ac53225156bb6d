//! The model at work on a scene.

use evpose_core::EventStream;
use evpose_sensor::{SensorConfig, SensorModel};

use crate::{Classes, Expected, GapError, Scene, Stage};

impl Scene {
    /// The events that a sensor makes of the scene.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn events(&self, config: &SensorConfig, seed: u64) -> Result<EventStream, GapError> {
        let all = self.events_up_to(config, seed, usize::MAX)?;
        Ok(all.unwrap_or_else(|| EventStream::empty(self.size())))
    }

    /// The same; nothing as soon as there are more than `most` events.
    fn events_up_to(
        &self,
        config: &SensorConfig,
        seed: u64,
        most: usize,
    ) -> Result<Option<EventStream>, GapError> {
        let mut run = SensorModel::from_config(config)?.start(self.size(), seed);
        let mut all = EventStream::empty(self.size());
        for (k, plane) in self.planes().iter().enumerate() {
            for event in run.expose(plane, self.time(k))?.iter().filter(|e| self.sees(e)) {
                all.push(event).map_err(|error| {
                    GapError::Recording(format!("{error}\n{}", config.to_toml()))
                })?;
            }
            if all.len() > most {
                return Ok(None);
            }
        }
        Ok(Some(all))
    }
}

impl Stage {
    /// A scene, and `reference` as the model that probes take times and places from: the sensor
    /// without noise and without delays.
    ///
    /// # Errors
    /// A reference that cannot be built or shown the scene.
    pub fn new(scene: Scene, reference: &SensorConfig) -> Result<Self, GapError> {
        let classes = Classes::of(&scene);
        let mut stage = Self { scene, classes, expected: Expected::default() };
        stage.expected = Expected::of(&stage.simulate(reference, 0)?);
        Ok(stage)
    }

    /// The events that a sensor makes of the scene.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn simulate(&self, config: &SensorConfig, seed: u64) -> Result<EventStream, GapError> {
        self.scene.events(config, seed)
    }

    /// The same; nothing as soon as there are more than `most` events.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn simulate_up_to(
        &self,
        config: &SensorConfig,
        seed: u64,
        most: usize,
    ) -> Result<Option<EventStream>, GapError> {
        self.scene.events_up_to(config, seed, most)
    }
}
