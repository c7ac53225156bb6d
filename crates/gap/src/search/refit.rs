//! Refit of the parameters that a sensor model has anyway.

use evpose_sensor::SensorConfig;
use rayon::prelude::*;

use super::initial_guess::initial_guesses;
use super::refinement::reset_insignificant;
use crate::fit::{Fit, descend};
use crate::free_parameter::FreeParameter;
use crate::parameters::ModelParameter;
use crate::{GapError, Objective};

/// Largest delay, microseconds, that is left to the pixels. A recording cannot distinguish a
/// constant delay of all pixels from an offset of the clock; pixel latencies beyond a millisecond
/// are rare.
const MAX_LATENCY_US: f64 = 900.0;
/// Gauss-Newton rounds of each fit.
const ROUNDS: usize = 4;
/// Steps of the coordinate search before the fit, large ones first.
const COORDINATE_STEPS: [f64; 2] = [3.0, 1.0];

/// Refits thresholds, background rates and clock offset of a model.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(super) fn refit(
    objective: &Objective<'_>,
    model: &SensorConfig,
    runs: u64,
) -> Result<Fit, GapError> {
    let mut free = FreeParameter::of_model();
    free.push(FreeParameter::Model(ModelParameter::ClockOffset));
    let mut guesses = initial_guesses(objective, model)?;
    guesses.push(model.clone());
    let fits = guesses
        .par_iter()
        .map(|guess| {
            let discrepancy = objective.discrepancy(guess, runs)?;
            Ok(Fit { discrepancy, model: guess.clone() })
        })
        .collect::<Result<Vec<_>, GapError>>()?;
    let best = fits.into_iter().min_by(|a, b| a.discrepancy.total_cmp(&b.discrepancy));
    let Some(mut best) = best else {
        return descend(objective, model, &free, None, runs, ROUNDS);
    };
    // One parameter after the other, then all together.
    for steps in COORDINATE_STEPS {
        for parameter in &free {
            for sign in [-1.0, 1.0] {
                let stepped = parameter.stepped(&best.model, sign * steps);
                let discrepancy = objective.discrepancy(&stepped, runs)?;
                if discrepancy < best.discrepancy {
                    best = Fit { model: stepped, discrepancy };
                    break;
                }
            }
        }
    }
    let mut fit = descend(objective, &best.model, &free, None, runs, ROUNDS)?;
    // Changes that do not help are undone; the other parameters are fitted once more.
    let significant = reset_insignificant(objective, model, &mut fit, &free)?;
    if !significant.is_empty() && significant.len() < free.len() {
        fit = descend(objective, &fit.model, &significant, None, runs, ROUNDS)?;
    }
    // A short delay is the pixels'; a clock can be off by anything.
    let offset_us = ModelParameter::ClockOffset.value(&fit.model);
    let given_us = ModelParameter::ClockOffset.value(model);
    if offset_us > given_us && offset_us - given_us < MAX_LATENCY_US {
        ModelParameter::ClockOffset.set(&mut fit.model, given_us);
        fit.discrepancy = objective.discrepancy(&fit.model, runs)?;
    }
    Ok(fit)
}
