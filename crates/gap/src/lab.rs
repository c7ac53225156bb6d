//! Where models are tried: one scene, one part of time, and the summary to be explained.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use evpose_core::{EventStream, TimeWindow};
use evpose_sensor::{EffectConfig, SensorConfig};
use rayon::prelude::*;

use crate::{Expectation, GapError, Layout, Stage, View};

/// So many times the events of the recording, or of the reference, a model may have, and so many
/// more.
const EXCESS: usize = 2;
const SPARE: usize = 5_000;

/// Runs that show how much numbers vary by chance.
const DITHERED_RUNS: u64 = 6;
/// Share of the variance that these runs have.
const DITHER_SHARE: f64 = 0.5;

/// A sensor with a little of every kind of noise, which shows how firm the numbers of a summary
/// are: what jumps under it is no ground for a name.
fn dithered(reference: &SensorConfig) -> SensorConfig {
    let mut config = reference.clone();
    config.effects.extend([
        EffectConfig::new("threshold_mismatch").with("sigma", 0.004),
        EffectConfig::new("threshold_temporal_noise").with("sigma", 0.004),
        EffectConfig::new("timestamp_jitter").with("sigma_us", 100.0),
        EffectConfig::new("uniform_noise").with("on_hz", 0.05).with("off_hz", 0.05),
    ]);
    config
}

/// Summaries of models, as text, and runs.
type Known = HashMap<(String, u64), Arc<Vec<f64>>>;

/// A measured recording beside its scene, and everything that was simulated for it so far.
#[derive(Debug)]
pub struct Lab<'a> {
    /// The scene.
    pub stage: &'a Stage,
    /// What is measured of events.
    pub layout: &'a Layout,
    /// The part of time that is looked at.
    pub window: TimeWindow,
    /// The recording.
    pub events: EventStream,
    /// What was measured of it.
    pub measured: Vec<f64>,
    /// Whether a fit may begin with the background of pixels at rest.
    pub(crate) begins_at_rest: bool,
    seed: u64,
    /// A model with more events than this is out of the question.
    most: usize,
    /// Variances that numbers have of chance.
    chance: Vec<f64>,
    known: Mutex<Known>,
}

impl<'a> Lab<'a> {
    /// Looks at a part of a recording. All noise of simulations comes from `seed`; `reference` is
    /// the sensor without noise.
    ///
    /// # Errors
    /// A reference that cannot be built or shown the scene.
    pub fn new(
        stage: &'a Stage,
        layout: &'a Layout,
        events: &EventStream,
        window: TimeWindow,
        reference: &SensorConfig,
        seed: u64,
    ) -> Result<Self, GapError> {
        // A camera may lose most of what the model has.
        let most = EXCESS * events.len().max(stage.expected.events()) + SPARE;
        let measured = layout.summarise(&View::new(stage, events, window));
        let mut lab = Self {
            stage,
            layout,
            window,
            events: events.clone(),
            measured,
            begins_at_rest: false,
            seed,
            most,
            chance: Vec::new(),
            known: Mutex::default(),
        };
        let dithered = lab.expect(&dithered(reference), DITHERED_RUNS)?;
        lab.chance = dithered.variance.iter().map(|v| DITHER_SHARE * v).collect();
        Ok(lab)
    }

    /// The summary of run number `run` of a model. Runs of the same number have the same draws
    /// in all models.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn run(&self, model: &SensorConfig, run: u64) -> Result<Arc<Vec<f64>>, GapError> {
        let key = (model.to_toml(), run);
        let lock = || self.known.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(known) = lock().get(&key) {
            return Ok(Arc::clone(known));
        }
        let seed = evpose_core::seed_for(self.seed, "run", run);
        let events = self.stage.simulate_up_to(model, seed, self.most)?;
        let summary = Arc::new(events.map_or_else(
            // Numbers that nothing is near to.
            || vec![f64::INFINITY; self.layout.entries.len()],
            |events| self.layout.summarise(&View::new(self.stage, &events, self.window)),
        ));
        lock().insert(key, Arc::clone(&summary));
        Ok(summary)
    }

    /// What a model makes one expect, from `runs` runs.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn expect(&self, model: &SensorConfig, runs: u64) -> Result<Expectation, GapError> {
        let runs = (0..runs)
            .into_par_iter()
            .map(|run| self.run(model, run))
            .collect::<Result<Vec<_>, _>>()?;
        let runs: Vec<Vec<f64>> = runs.iter().map(|run| run.to_vec()).collect();
        Ok(Expectation::of_runs(self.layout, &runs, &self.chance))
    }

    /// How many different models and runs were simulated.
    pub fn simulated(&self) -> usize {
        self.known.lock().unwrap_or_else(std::sync::PoisonError::into_inner).len()
    }
}
