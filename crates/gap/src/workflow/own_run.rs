//! A recording that is a run of our own model: what chance alone must not be taken for a gap.

use evpose_core::seed_for;
use evpose_sensor::SensorConfig;

use super::{Case, chance_of_largest, prepared};
use crate::input::Nominal;
use crate::{GapError, Lab, Layout, Scene, Stage};

/// What comes of such a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OwnRun {
    /// The probability of its largest deviation, see
    /// [`chance_of_largest`](super::chance_of_largest).
    pub p: f64,
    /// Events of the recording.
    pub events: usize,
}

/// Records `scene` with `model` and its nominal values and asks how probable that is. Over seeds, `p`
/// is uniform where the model has noise; a model without noise makes the same events every time.
///
/// # Errors
/// A model that cannot be built or shown the scene, or that makes no events.
pub fn own_run(
    scene: Scene,
    model: &SensorConfig,
    nominal: Option<&Nominal>,
    replicates: u64,
    seed: u64,
) -> Result<OwnRun, GapError> {
    let model = prepared(model, nominal);
    let stage = Stage::new(scene.clone(), &model.reference)?;
    let events = stage.simulate(&model.config, seed_for(seed, "recording of our own", 0))?;
    let Case { measured, window, .. } = Case::new(&events, scene)?;
    let layout = Layout::of_all_probes();
    let lab = Lab::new(&stage, &layout, &measured, window, &model.reference, seed)?;
    let p = chance_of_largest(&lab, &model.config, replicates)?;
    Ok(OwnRun { p, events: measured.len() })
}
