//! Runs of the model itself as recordings: they have no gap, so that their p-values must be
//! uniform.

use evpose_core::seed_for;
use evpose_sensor::SensorConfig;

use super::{ComparisonCase, p_of_largest_deviation, prepared};
use crate::input::Nominal;
use crate::{GapError, Layout, LightSequence, Objective, ReferenceScene};

/// Result of such a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OwnRun {
    /// p-value of its largest deviation, see [`p_of_largest_deviation`].
    pub p: f64,
    /// Number of events of the recording.
    pub events: usize,
}

/// Records `scene` with `model` and its nominal values, and tests the recording against the model.
/// Over seeds, `p` is uniform if the model has noise; without noise, all runs have the same events.
///
/// # Errors
/// A model that cannot be built or shown the scene, or that makes no events.
pub fn own_run(
    scene: LightSequence,
    model: &SensorConfig,
    nominal: Option<&Nominal>,
    replicates: u64,
    seed: u64,
) -> Result<OwnRun, GapError> {
    let model = prepared(model, nominal);
    let reference_scene = ReferenceScene::new(scene.clone(), &model.reference)?;
    // A seed of no run of the objective: such a run would equal this recording event by event.
    let events =
        reference_scene.simulate(&model.config, seed_for(seed, "recording of our own", 0))?;
    let ComparisonCase { measured, window, .. } = ComparisonCase::new(&events, scene)?;
    let layout = Layout::of_all_probes();
    let objective =
        Objective::new(&reference_scene, &layout, &measured, window, &model.reference, seed)?;
    let p = p_of_largest_deviation(&objective, &model.config, replicates)?;
    Ok(OwnRun { p, events: measured.len() })
}
