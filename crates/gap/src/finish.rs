//! A fit made as plain as it can be: what does not help goes.

use evpose_sensor::{ParamSpec, STAGES, SensorConfig, Strength, Value};

use crate::fit::{Fit, descend, misfit_of};
use crate::knob::Knob;
use crate::parameters::Parameter;
use crate::parameters::with_given_numbers;
use crate::search::{Found, own, parameter_knobs};
use crate::{GapError, Lab};

/// A number without which the misfit is hardly larger was right before, or is not needed.
const LEAST_LOSS: f64 = 8.0;
/// The same, as a share of the misfit: what a model that is not quite right makes of a number that
/// has nothing to do with it.
const LEAST_SHARE: f64 = 0.04;
/// Offsets of the clock of fewer steps do not matter.
const LEAST_STEPS: f64 = 0.6;
/// Rounds of the fit of all numbers together.
const ROUNDS: usize = 3;

impl Found {
    /// Gives the effect each number that its form lacks, where it does better with it: a form is chosen
    /// by a few strengths on a short recording, on which the plainest may look best.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(crate) fn grow(&mut self, lab: &Lab<'_>, given: &SensorConfig) -> Result<(), GapError> {
        let Some(spec) = STAGES.iter().find(|spec| spec.name == self.name) else { return Ok(()) };
        if matches!(spec.signature.strength, Strength::RisingAlone(_)) {
            return Ok(());
        }
        let typical = spec.typical();
        for param in spec.params.iter().filter(|param| param.neutral.is_some()) {
            let Some(value) = typical.number(param.name) else { continue };
            if self.trial.effect.params.contains_key(param.name) {
                continue;
            }
            let mut fuller = self.clone();
            fuller.add(param, value);
            // Numbers of the model may have done what this one is for.
            let as_given = with_given_numbers(&fuller.fit.model, given);
            let as_found = fuller.fit.model.clone();
            for start in [&as_found, &as_given] {
                let fit = descend(lab, start, &own(&fuller.trial), None, 1, ROUNDS)?;
                if with_margin(fit.misfit) < self.fit.misfit {
                    fuller.fit = fit;
                    *self = fuller.clone();
                }
                if as_given == as_found {
                    break;
                }
            }
        }
        Ok(())
    }

    /// Fits all numbers together, and leaves out those of the effect that it can do without; numbers
    /// of the model that did not have to move are again what `given` has.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(crate) fn finish(&mut self, lab: &Lab<'_>, given: &SensorConfig) -> Result<(), GapError> {
        for param in self.trial.params.clone() {
            if param.name == self.trial.params[0].name || param.neutral.is_none() {
                continue;
            }
            let mut plainer = self.clone();
            plainer.drop(param.name);
            plainer.fit = descend(lab, &plainer.fit.model, &own(&plainer.trial), None, 1, ROUNDS)?;
            if plainer.fit.misfit < with_margin(self.fit.misfit) {
                *self = plainer;
            }
        }
        let mut knobs = own(&self.trial);
        knobs.extend(kept(lab, given, &mut self.fit, &parameter_knobs())?);
        self.fit = descend(lab, &self.fit.model, &knobs, None, 1, ROUNDS)?;
        Ok(())
    }

    /// Fits the effect once more with the short steps that it needs.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(crate) fn refine(&mut self, lab: &Lab<'_>) -> Result<(), GapError> {
        if let Some(model) = self.trial.with_short_steps(&self.fit.model) {
            let fit = descend(lab, &model, &own(&self.trial), None, 1, ROUNDS)?;
            if fit.misfit < self.fit.misfit {
                self.fit = fit;
            }
        }
        Ok(())
    }

    /// Gives the effect a number.
    fn add(&mut self, param: &'static ParamSpec, value: f64) {
        let effects = self.fit.model.effects.iter_mut().filter(|effect| effect.name == self.name);
        for effect in effects.chain(std::iter::once(&mut self.trial.effect)) {
            effect.params.insert(param.name.to_owned(), Value::from(value));
        }
        self.trial.params.push(param);
    }

    /// Takes a number out of the effect.
    fn drop(&mut self, name: &str) {
        let effects = self.fit.model.effects.iter_mut().filter(|effect| effect.name == self.name);
        for effect in effects.chain(std::iter::once(&mut self.trial.effect)) {
            effect.params.remove(name);
        }
        self.trial.params.retain(|param| param.name != name);
    }
}

fn with_margin(misfit: f64) -> f64 {
    misfit + LEAST_LOSS.max(LEAST_SHARE * misfit)
}

/// Sets numbers of the model that do not help back to what they were; the knobs of the others.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(crate) fn kept(
    lab: &Lab<'_>,
    given: &SensorConfig,
    fit: &mut Fit,
    knobs: &[Knob],
) -> Result<Vec<Knob>, GapError> {
    let mut kept = Vec::new();
    for knob in knobs {
        let Knob::Parameter(parameter) = knob else { continue };
        let mut model = fit.model.clone();
        parameter.set(&mut model, parameter.value(given));
        let misfit = misfit_of(lab, &model, 1)?;
        let steps = parameter.steps(parameter.value(given), parameter.value(&fit.model)).abs();
        let is_small = *parameter == Parameter::ClockOffset && steps < LEAST_STEPS;
        if is_small || misfit < fit.misfit + LEAST_LOSS {
            *fit = Fit { model, misfit };
        } else {
            kept.push(*knob);
        }
    }
    Ok(kept)
}
