//! What a fit turns: a number of the model, on a scale on which summaries change evenly.

use evpose_sensor::{ParamSpec, Scale, SensorConfig};

use crate::candidate::limits;
use crate::parameters::Parameter;

/// One number of a model.
#[derive(Debug, Clone, Copy)]
pub enum Knob {
    /// A number that the model has anyway.
    Parameter(Parameter),
    /// A number of an effect that was added.
    Effect(&'static str, &'static ParamSpec),
}

/// Ratio of one step of a number on a logarithmic scale.
const RATIO: f64 = 1.12;
/// Steps across the typical range of a number on a linear scale.
const STEPS: f64 = 30.0;

impl Knob {
    /// Its value in a model.
    pub fn value(self, model: &SensorConfig) -> f64 {
        match self {
            Self::Parameter(parameter) => parameter.value(model),
            Self::Effect(effect, param) => model
                .effect(effect)
                .and_then(|effect| effect.number(param.name))
                .or(param.neutral)
                .unwrap_or(0.0),
        }
    }

    /// The model with the number some steps away from what it is.
    pub fn turned(self, model: &SensorConfig, steps: f64) -> SensorConfig {
        let mut turned = model.clone();
        let value = self.value(model);
        match self {
            Self::Parameter(parameter) => {
                parameter.set(&mut turned, parameter.stepped(value, steps));
            }
            Self::Effect(name, param) => {
                let (low, high) = limits(param);
                let value = match param.scale {
                    Scale::Log => value.max(low) * RATIO.powf(steps),
                    Scale::Linear => value + (high - low) / STEPS * steps,
                };
                let value = value.clamp(low, high);
                for effect in turned.effects.iter_mut().filter(|effect| effect.name == name) {
                    *effect = effect.clone().with(param.name, value);
                }
            }
        }
        turned
    }

    /// Whether the next step upwards would leave what is allowed.
    pub fn is_at_top(self, model: &SensorConfig) -> bool {
        match self {
            Self::Parameter(_) => false,
            Self::Effect(_, param) => self.value(model) >= limits(param).1 * 0.999,
        }
    }

    /// Standard deviation, in steps, of what is likely before looking at data.
    pub fn prior_steps(self) -> f64 {
        match self {
            Self::Parameter(parameter) => parameter.prior_steps(),
            Self::Effect(..) => 20.0,
        }
    }
}
