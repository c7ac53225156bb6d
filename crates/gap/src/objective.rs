//! Objective of fits: the discrepancy between the summary statistics of a recording and of
//! simulations of a model, on one scene and one window of time.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use evpose_core::{EventStream, TimeWindow};
use evpose_sensor::{EffectConfig, STAGES, SensorConfig};
use rayon::prelude::*;

use crate::compare::{discrepancy, gap};
use crate::search_spec::Searched;
use crate::{Expectation, GapError, Layout, ReferenceScene, View};

/// A simulation is stopped at this multiple of the events of the recording or of the reference, and
/// this many more: such a model is hopeless, and noise can make millions of events.
const MAX_EVENTS_FACTOR: usize = 2;
const MAX_EVENTS_OFFSET: usize = 5_000;

/// Runs of the dithered reference, from which the sampling variance of statistics is estimated.
const DITHERED_RUNS: u64 = 6;
/// Fraction of that variance that is used: the dither exceeds the noise of most cameras.
const DITHER_SHARE: f64 = 0.5;

/// The reference with a little of every kind of noise. It shows how robust each statistic is: one
/// that jumps under so little noise is no evidence for an effect.
fn dithered(reference: &SensorConfig) -> SensorConfig {
    let mut config = reference.clone();
    for spec in STAGES.entries().iter().filter(|spec| !spec.search().dither.is_empty()) {
        let effect = EffectConfig::new(spec.name);
        let with = |effect: EffectConfig, (key, value): &(&str, f64)| effect.with(key, *value);
        config.effects.push(spec.search().dither.iter().fold(effect, with));
    }
    config
}

/// Summaries by model (as TOML) and run.
type Cache = HashMap<(String, u64), Arc<Vec<f64>>>;

/// A recording with its scene, and a cache of the summaries of all simulations so far.
#[derive(Debug)]
pub struct Objective<'a> {
    /// Scene, classes and reference events.
    pub reference_scene: &'a ReferenceScene,
    /// Layout of the summary statistics.
    pub layout: &'a Layout,
    /// The window of time whose events are compared.
    pub window: TimeWindow,
    /// Events of the recording.
    pub events: EventStream,
    /// Summary statistics of the recording, see [`Layout::summarise`].
    pub measured: Vec<f64>,
    /// Whether a fit may start from background rates estimated at pixels at rest.
    pub(crate) begins_at_rest: bool,
    seed: u64,
    /// Events at which a simulation is stopped.
    max_events: usize,
    /// Minimum sampling variance of each statistic.
    min_variances: Vec<f64>,
    cache: Mutex<Cache>,
}

impl<'a> Objective<'a> {
    /// Computes the summary of a window of a recording. `seed` seeds all noise of simulations;
    /// `reference` is the sensor without noise.
    ///
    /// # Errors
    /// A reference that cannot be built or shown the scene.
    pub fn new(
        reference_scene: &'a ReferenceScene,
        layout: &'a Layout,
        events: &EventStream,
        window: TimeWindow,
        reference: &SensorConfig,
        seed: u64,
    ) -> Result<Self, GapError> {
        // A camera may lose most of the reference's events, so that the larger count decides.
        let max_events = MAX_EVENTS_FACTOR * events.len().max(reference_scene.expected.events())
            + MAX_EVENTS_OFFSET;
        let measured = layout.summarise(&View::new(reference_scene, events, window));
        let mut objective = Self {
            reference_scene,
            layout,
            window,
            events: events.clone(),
            measured,
            begins_at_rest: false,
            seed,
            max_events,
            min_variances: Vec::new(),
            cache: Mutex::default(),
        };
        // A model without noise has no variance: a reference with a little noise gives the least.
        let dithered = objective.expect(&dithered(reference), DITHERED_RUNS)?;
        objective.min_variances = dithered.variance.iter().map(|v| DITHER_SHARE * v).collect();
        Ok(objective)
    }

    /// The summary of run `run` of a model. Runs of one index have the same random numbers in all
    /// models, so that differences between models are free of noise.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn run(&self, model: &SensorConfig, run: u64) -> Result<Arc<Vec<f64>>, GapError> {
        let key = (model.to_toml(), run);
        let lock = || self.cache.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(known) = lock().get(&key) {
            return Ok(Arc::clone(known));
        }
        let seed = evpose_core::seed_for(self.seed, "run", run);
        let events = self.reference_scene.simulate_up_to(model, seed, self.max_events)?;
        let summary = Arc::new(events.map_or_else(
            // Stopped: a summary that is infinitely far from any other.
            || vec![f64::INFINITY; self.layout.entries.len()],
            |events| self.layout.summarise(&View::new(self.reference_scene, &events, self.window)),
        ));
        lock().insert(key, Arc::clone(&summary));
        Ok(summary)
    }

    /// Events of run `run` of a model; none of a model with far too many.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(crate) fn events_of_run(
        &self,
        model: &SensorConfig,
        run: u64,
    ) -> Result<Option<EventStream>, GapError> {
        let seed = evpose_core::seed_for(self.seed, "run", run);
        self.reference_scene.simulate_up_to(model, seed, self.max_events)
    }

    /// Mean and variance of the summary of a model over `runs` runs.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn expect(&self, model: &SensorConfig, runs: u64) -> Result<Expectation, GapError> {
        let runs = (0..runs)
            .into_par_iter()
            .map(|run| self.run(model, run))
            .collect::<Result<Vec<_>, _>>()?;
        let runs: Vec<Vec<f64>> = runs.iter().map(|run| run.to_vec()).collect();
        Ok(Expectation::of_runs(self.layout, &runs, &self.min_variances))
    }

    /// The discrepancy statistic of a model, from `runs` runs.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn discrepancy(&self, model: &SensorConfig, runs: u64) -> Result<f64, GapError> {
        let expected = self.expect(model, runs)?;
        Ok(discrepancy(&expected.deviations(self.layout, &self.measured)))
    }

    /// The discrepancy statistic and the gap of a model, from `runs` runs.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn score(&self, model: &SensorConfig, runs: u64) -> Result<(f64, f64), GapError> {
        let deviations = self.expect(model, runs)?.deviations(self.layout, &self.measured);
        Ok((discrepancy(&deviations), gap(self.layout, &deviations)))
    }
}
