//! Free parameters of a fit, on scales on which summary statistics change about linearly.

use evpose_sensor::{NumberSpec, STAGES, Scale, SensorConfig, StageSpec};

use crate::candidate::{Trial, limits};
use crate::parameters::ModelParameter;
use crate::search_spec::Searched;

/// One free parameter of a fit.
#[derive(Debug, Clone, Copy)]
pub enum FreeParameter {
    /// A parameter that the model has anyway.
    Model(ModelParameter),
    /// A parameter of an added effect: the effect and its parameter.
    Effect(&'static StageSpec, &'static NumberSpec),
}

/// Factor of one step of a parameter on a logarithmic scale. A tenth or so is the coarsest step at
/// which summary statistics change about linearly.
const LOG_STEP_RATIO: f64 = 1.12;
/// Steps across the typical range of a parameter on a linear scale.
const LINEAR_STEPS: f64 = 30.0;

impl FreeParameter {
    /// The model parameters that every fit may change. The offset of the clock is not among them,
    /// because beside an effect it would take the place of a latency.
    pub fn of_model() -> Vec<Self> {
        let all = ModelParameter::ALL.into_iter();
        all.filter(|parameter| *parameter != ModelParameter::ClockOffset).map(Self::Model).collect()
    }

    /// The fitted parameters of a trial, the strength first.
    pub fn of_effect(trial: &Trial) -> Vec<Self> {
        trial.params.iter().map(|param| Self::Effect(trial.spec, param)).collect()
    }

    pub(crate) fn is_model(&self, parameter: ModelParameter) -> bool {
        matches!(self, Self::Model(own) if *own == parameter)
    }

    /// Finds a parameter by the names of a finding and of its parameter in a verdict.
    pub fn by_name(finding: &str, parameter: &str) -> Option<Self> {
        if let Some(parameter) = ModelParameter::ALL.iter().find(|known| known.name() == finding) {
            return Some(Self::Model(*parameter));
        }
        let spec = STAGES.find(finding)?;
        let param = spec.number_params().find(|param| param.name == parameter)?;
        Some(Self::Effect(spec, param))
    }

    /// Steps from one value to another; not finite where a logarithmic scale has no such value.
    pub fn steps(self, from: f64, to: f64) -> f64 {
        match self {
            Self::Model(parameter) => parameter.steps(from, to),
            Self::Effect(spec, param) => match param.scale {
                Scale::Log => (to / from).ln() / LOG_STEP_RATIO.ln(),
                Scale::Linear => (to - from) / linear_step(spec, param),
            },
        }
    }

    /// Value in a model.
    pub fn value(self, model: &SensorConfig) -> f64 {
        match self {
            Self::Model(parameter) => parameter.value(model),
            Self::Effect(spec, param) => model
                .effect(spec.name)
                .and_then(|effect| effect.number(param.name))
                // An effect that is not in the model, or does not set the parameter, has its
                // neutral value.
                .or(param.default)
                .unwrap_or(0.0),
        }
    }

    /// The model with the parameter changed by some steps.
    pub fn stepped(self, model: &SensorConfig, steps: f64) -> SensorConfig {
        let value = self.value(model);
        let stepped = match self {
            Self::Model(parameter) => parameter.stepped(value, steps),
            Self::Effect(spec, param) => {
                let (low, high) = limits(spec, param);
                let value = match param.scale {
                    // From zero, a ratio leads nowhere: the first step is from the lower limit.
                    Scale::Log => value.max(low) * LOG_STEP_RATIO.powf(steps),
                    Scale::Linear => value + linear_step(spec, param) * steps,
                };
                value.clamp(low, high)
            }
        };
        self.with_value(model, stepped)
    }

    /// `count` values across the range of a parameter of an effect whose estimate is rough; none of
    /// other parameters.
    pub(crate) fn rough_values(self, count: usize) -> Vec<f64> {
        match self {
            Self::Effect(spec, param) if spec.search().rough.contains(&param.name) => {
                let (low, high) = limits(spec, param);
                let at = |i: usize| low + (high - low) * i as f64 / count as f64;
                (0..count).map(at).collect()
            }
            _ => Vec::new(),
        }
    }

    pub(crate) fn with_value(self, model: &SensorConfig, value: f64) -> SensorConfig {
        let mut model = model.clone();
        match self {
            Self::Model(parameter) => parameter.set(&mut model, value),
            Self::Effect(spec, param) => {
                for effect in model.effects.iter_mut().filter(|effect| effect.name == spec.name) {
                    *effect = effect.clone().with(param.name, value);
                }
            }
        }
        model
    }

    /// Whether the next step upwards would leave the allowed range.
    pub fn is_at_top(self, model: &SensorConfig) -> bool {
        match self {
            Self::Model(_) => false,
            Self::Effect(spec, param) => self.value(model) >= limits(spec, param).1 * 0.999,
        }
    }

    /// Standard deviation of the prior, in steps.
    pub fn prior_steps(self) -> f64 {
        match self {
            Self::Model(parameter) => parameter.prior_steps(),
            // A decade of a logarithmic parameter: hardly a constraint.
            Self::Effect(..) => 20.0,
        }
    }
}

/// Step of a parameter on a linear scale: of one that is searched far beyond what is typical, the
/// geometric mean of the steps of both ranges.
fn linear_step(spec: &StageSpec, param: &NumberSpec) -> f64 {
    let (low, high) = limits(spec, param);
    let typical = param.typical.map_or(high - low, |(low, high)| high - low);
    ((high - low) * typical.min(high - low)).sqrt() / LINEAR_STEPS
}

#[cfg(test)]
mod tests {
    use super::*;
    use evpose_sensor::EffectConfig;

    #[test]
    fn steps_are_the_inverse_of_stepping() {
        let effect = |name: &str, key, value| SensorConfig {
            effects: vec![EffectConfig::new(name).with(key, value)],
        };
        let cases = [
            (effect("leak_on", "rate_hz", 0.3), "leak_on", "rate_hz"),
            (effect("veiling_glare", "fraction", 0.05), "veiling_glare", "fraction"),
            (effect("level_crossing", "threshold_on", 0.25), "threshold_on", "threshold_on"),
            (effect("clock_offset_drift", "offset_us", 900.0), "clock_offset", "clock_offset"),
        ];
        for (model, finding, parameter) in cases {
            let free = FreeParameter::by_name(finding, parameter).unwrap();
            let stepped = free.stepped(&model, 1.5);
            let steps = free.steps(free.value(&model), free.value(&stepped));
            assert!((steps - 1.5).abs() < 1e-9, "{finding}: {steps}");
        }
        assert!(FreeParameter::by_name("leak_on", "no such parameter").is_none());
    }
}
