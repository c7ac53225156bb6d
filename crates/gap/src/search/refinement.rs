//! Refinement of fitted candidates: parameters that help are added, parameters that do not are
//! dropped, and the effects of an answer are fitted together.

use evpose_sensor::{NumberSpec, SensorConfig, Strength, Value};

use super::identification::FittedCandidate;
use crate::fit::{Fit, descend};
use crate::free_parameter::FreeParameter;
use crate::parameters::{ModelParameter, with_given_parameters};
use crate::{GapError, Objective};

/// Minimum increase of the discrepancy without a parameter for the parameter to be significant.
const MIN_LOSS: f64 = 8.0;
/// The same as a fraction of the discrepancy: a slightly wrong model gains as much from a parameter
/// that has nothing to do with the recording.
const MIN_LOSS_FRACTION: f64 = 0.04;
/// Offsets of the clock of fewer steps (a tenth of a millisecond each) are insignificant.
const MIN_OFFSET_STEPS: f64 = 0.6;
/// Gauss-Newton rounds of a fit of one candidate.
const ROUNDS: usize = 3;

impl FittedCandidate {
    /// Adds each parameter of the effect that the trial lacks, if the fit improves with it: the
    /// form of a trial is chosen at a few strengths on a short recording, which favours few
    /// parameters.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn add_parameters(
        &mut self,
        objective: &Objective<'_>,
        given: &SensorConfig,
    ) -> Result<(), GapError> {
        let spec = self.trial.spec;
        if matches!(spec.signature.strength, Strength::RisingAlone(_)) {
            return Ok(());
        }
        let typical = spec.typical();
        for param in spec.number_params().filter(|param| param.default.is_some()) {
            let Some(value) = typical.number(param.name) else { continue };
            if self.trial.effect.params.contains_key(param.name) {
                continue;
            }
            let mut fuller = self.clone();
            fuller.insert(param, value);
            // The model's own parameters may have absorbed what this one is for.
            let from_given = with_given_parameters(&fuller.fit.model, given);
            let from_fitted = fuller.fit.model.clone();
            for start in [&from_fitted, &from_given] {
                let free = FreeParameter::of_effect(&fuller.trial);
                let fit = descend(objective, start, &free, None, 1, ROUNDS)?;
                // A parameter has to be worth more than its freedom.
                if with_margin(fit.discrepancy) < self.fit.discrepancy {
                    fuller.fit = fit;
                    *self = fuller.clone();
                }
                if from_given == from_fitted {
                    break;
                }
            }
        }
        Ok(())
    }

    /// Drops the parameters of the effect that are insignificant, resets those of the model that
    /// are, and fits the others together.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn drop_parameters(
        &mut self,
        objective: &Objective<'_>,
        given: &SensorConfig,
    ) -> Result<(), GapError> {
        for param in self.trial.params.clone() {
            // Without its strength the effect would be gone; without a neutral value it has no
            // smaller form.
            if param.name == self.trial.params[0].name || param.default.is_none() {
                continue;
            }
            let mut plainer = self.clone();
            plainer.remove(param.name);
            let free = FreeParameter::of_effect(&plainer.trial);
            plainer.fit = descend(objective, &plainer.fit.model, &free, None, 1, ROUNDS)?;
            if plainer.fit.discrepancy < with_margin(self.fit.discrepancy) {
                *self = plainer;
            }
        }
        let mut free = FreeParameter::of_effect(&self.trial);
        // Now that the effect explains its part, changes of the model that stood in for it lose
        // theirs.
        let of_model = FreeParameter::of_model();
        free.extend(reset_insignificant(objective, given, &mut self.fit, &of_model)?);
        self.fit = descend(objective, &self.fit.model, &free, None, 1, ROUNDS)?;
        Ok(())
    }

    /// Fits the effect once more with the short time steps that it needs.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn refine_time_steps(&mut self, objective: &Objective<'_>) -> Result<(), GapError> {
        if let Some(model) = self.trial.with_short_steps(&self.fit.model) {
            let free = FreeParameter::of_effect(&self.trial);
            let fit = descend(objective, &model, &free, None, 1, ROUNDS)?;
            if fit.discrepancy < self.fit.discrepancy {
                self.fit = fit;
            }
        }
        Ok(())
    }

    /// Adds a parameter to the effect, in the model and in the trial.
    fn insert(&mut self, param: &'static NumberSpec, value: f64) {
        let effects = self.fit.model.effects.iter_mut().filter(|effect| effect.name == self.name);
        for effect in effects.chain(std::iter::once(&mut self.trial.effect)) {
            effect.params.insert(param.name.to_owned(), Value::from(value));
        }
        self.trial.params.push(param);
    }

    /// Removes a parameter of the effect, from the model and from the trial.
    fn remove(&mut self, name: &str) {
        let effects = self.fit.model.effects.iter_mut().filter(|effect| effect.name == self.name);
        for effect in effects.chain(std::iter::once(&mut self.trial.effect)) {
            effect.params.remove(name);
        }
        self.trial.params.retain(|param| param.name != name);
    }
}

/// The discrepancy at which a model with one parameter less, or more, is as good.
fn with_margin(discrepancy: f64) -> f64 {
    discrepancy + MIN_LOSS.max(MIN_LOSS_FRACTION * discrepancy)
}

/// Resets parameters of the model to their given values where a change does not help, and returns
/// those that changed significantly.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(super) fn reset_insignificant(
    objective: &Objective<'_>,
    given: &SensorConfig,
    fit: &mut Fit,
    free: &[FreeParameter],
) -> Result<Vec<FreeParameter>, GapError> {
    let mut significant = Vec::new();
    for free_parameter in free {
        let FreeParameter::Model(parameter) = free_parameter else { continue };
        let mut model = fit.model.clone();
        parameter.set(&mut model, parameter.value(given));
        // Not refitted: a reset that needs other parameters to make up for it is significant.
        let discrepancy = objective.discrepancy(&model, 1)?;
        let steps = parameter.steps(parameter.value(given), parameter.value(&fit.model)).abs();
        let is_small = *parameter == ModelParameter::ClockOffset && steps < MIN_OFFSET_STEPS;
        if is_small || discrepancy < fit.discrepancy + MIN_LOSS {
            *fit = Fit { model, discrepancy };
        } else {
            significant.push(*free_parameter);
        }
    }
    Ok(significant)
}
