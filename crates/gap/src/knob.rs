//! What a fit turns: a number of the model, on a scale on which summaries change evenly.

use evpose_sensor::{ParamSpec, STAGES, Scale, SensorConfig};

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
    /// The number of a finding of a verdict, by the names that it has there.
    pub fn named(finding: &str, number: &str) -> Option<Self> {
        if let Some(parameter) = Parameter::ALL.iter().find(|known| known.name() == finding) {
            return Some(Self::Parameter(*parameter));
        }
        let spec = STAGES.iter().find(|spec| spec.name == finding)?;
        let param = spec.params.iter().find(|param| param.name == number)?;
        Some(Self::Effect(spec.name, param))
    }

    /// Steps from one value to another; not finite where there is no way.
    pub fn steps(self, from: f64, to: f64) -> f64 {
        match self {
            Self::Parameter(parameter) => parameter.steps(from, to),
            Self::Effect(_, param) => match param.scale {
                Scale::Log => (to / from).ln() / RATIO.ln(),
                Scale::Linear => {
                    let (low, high) = limits(param);
                    (to - from) * STEPS / (high - low)
                }
            },
        }
    }

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

#[cfg(test)]
mod tests {
    use super::*;
    use evpose_sensor::EffectConfig;

    #[test]
    fn steps_lead_back_to_where_a_knob_was_turned_to() {
        let effect = |name: &str, key, value| SensorConfig {
            effects: vec![EffectConfig::new(name).with(key, value)],
        };
        let cases = [
            (effect("leak_on", "rate_hz", 0.3), "leak_on", "rate_hz"),
            (effect("veiling_glare", "fraction", 0.05), "veiling_glare", "fraction"),
            (effect("level_crossing", "threshold_on", 0.25), "threshold_on", "threshold_on"),
            (effect("clock_offset_drift", "offset_us", 900.0), "clock_offset", "clock_offset"),
        ];
        for (model, finding, number) in cases {
            let knob = Knob::named(finding, number).unwrap();
            let turned = knob.turned(&model, 1.5);
            let steps = knob.steps(knob.value(&model), knob.value(&turned));
            assert!((steps - 1.5).abs() < 1e-9, "{finding}: {steps}");
        }
        assert!(Knob::named("leak_on", "no such number").is_none());
    }
}
