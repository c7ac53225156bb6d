//! Parameters that every sensor model has. A gap that refitting them closes is a wrong parameter,
//! not a missing effect.

use evpose_sensor::{EffectConfig, STAGES, SensorConfig, StageSpec};

use crate::common_parameter::CommonParameter;
use crate::search_spec::Searched;
use serde::Serialize;

/// A parameter of the model that is refitted before and together with effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ModelParameter {
    /// ON threshold, fitted as a ratio.
    ThresholdOn,
    /// OFF threshold, fitted as a ratio.
    ThresholdOff,
    /// Background rate of ON events per pixel, Hz.
    NoiseOn,
    /// Background rate of OFF events per pixel, Hz.
    NoiseOff,
    /// Delay of the recording's clock, microseconds.
    ClockOffset,
}

/// Step of a threshold, as a logarithm: 3 % changes counts of a typical recording significantly.
const THRESHOLD_STEP: f64 = 0.03;
/// Step of the square root of a background rate, in the square root of Hz.
const ROOT_RATE_STEP: f64 = 0.1;
/// Step of the clock offset, microseconds: a tenth of the frame interval of a scene of 1 kHz.
const OFFSET_STEP_US: f64 = 100.0;
/// Largest clock offset, microseconds.
const MAX_OFFSET_US: f64 = 1e5;
/// Smallest positive rate of the noise stage, Hz.
const MIN_RATE_HZ: f64 = 1e-4;

impl ModelParameter {
    /// All parameters.
    pub const ALL: [Self; 5] =
        [Self::ThresholdOn, Self::ThresholdOff, Self::NoiseOn, Self::NoiseOff, Self::ClockOffset];

    /// The name in verdicts.
    pub fn name(self) -> &'static str {
        match self {
            Self::ThresholdOn => "threshold_on",
            Self::ThresholdOff => "threshold_off",
            Self::NoiseOn => "noise_on_hz",
            Self::NoiseOff => "noise_off_hz",
            Self::ClockOffset => "clock_offset",
        }
    }

    /// The unit in verdicts.
    pub fn unit(self) -> &'static str {
        match self {
            Self::ThresholdOn | Self::ThresholdOff => "ln",
            Self::NoiseOn | Self::NoiseOff => "Hz",
            Self::ClockOffset => "us",
        }
    }

    /// The same parameter in the catalogue.
    pub fn common(self) -> CommonParameter {
        match self {
            Self::ThresholdOn => CommonParameter::ThresholdOn,
            Self::ThresholdOff => CommonParameter::ThresholdOff,
            Self::NoiseOn => CommonParameter::NoiseOn,
            Self::NoiseOff => CommonParameter::NoiseOff,
            Self::ClockOffset => CommonParameter::ClockOffset,
        }
    }

    /// The value in a model.
    pub fn value(self, model: &SensorConfig) -> f64 {
        let (owner, key) = self.common().place();
        model.effect(owner.name).and_then(|effect| effect.number(key)).unwrap_or(0.0)
    }

    /// Sets the value in a model, to which the effect is added where it is missing.
    pub fn set(self, model: &mut SensorConfig, value: f64) {
        let (owner, key) = self.common().place();
        let name = owner.name;
        if matches!(self, Self::ThresholdOn | Self::ThresholdOff) && value <= 0.0 {
            // The model has another change detector, without thresholds.
            return;
        }
        let value = match self {
            // The noise stage accepts zero, but no smaller positive rate.
            Self::NoiseOn | Self::NoiseOff if value < MIN_RATE_HZ => 0.0,
            Self::ThresholdOn | Self::ThresholdOff => value.clamp(0.01, 5.0),
            _ => value,
        };
        if model.effect(name).is_none() {
            if value == 0.0 {
                return;
            }
            model.insert(EffectConfig::new(name));
        }
        for effect in model.effects.iter_mut().filter(|effect| effect.name == name) {
            *effect = effect.clone().with(key, value);
        }
        // Stages without background or clock offset would be entries without an effect.
        let is_idle = |effect: &EffectConfig| {
            matches!(self, Self::NoiseOn | Self::NoiseOff | Self::ClockOffset)
                && effect.name == name
                && effect.params.keys().all(|key| effect.number(key) == Some(0.0))
        };
        model.effects.retain(|effect| !is_idle(effect));
    }

    /// The value some steps away. A step is a change that shows well in a summary.
    pub fn stepped(self, value: f64, steps: f64) -> f64 {
        match self {
            Self::ThresholdOn | Self::ThresholdOff => value * (THRESHOLD_STEP * steps).exp(),
            // The square root stabilises the variance of counts.
            Self::NoiseOn | Self::NoiseOff => {
                let root = value.sqrt() + ROOT_RATE_STEP * steps;
                if root > 0.0 { root * root } else { 0.0 }
            }
            Self::ClockOffset => {
                (value + OFFSET_STEP_US * steps).clamp(-MAX_OFFSET_US, MAX_OFFSET_US)
            }
        }
    }

    /// Steps from one value to another.
    pub fn steps(self, from: f64, to: f64) -> f64 {
        match self {
            Self::ThresholdOn | Self::ThresholdOff => (to / from).ln() / THRESHOLD_STEP,
            Self::NoiseOn | Self::NoiseOff => (to.sqrt() - from.sqrt()) / ROOT_RATE_STEP,
            Self::ClockOffset => (to - from) / OFFSET_STEP_US,
        }
    }

    /// Standard deviation of the prior, in steps.
    pub fn prior_steps(self) -> f64 {
        match self {
            Self::ThresholdOn | Self::ThresholdOff => 10.0,
            Self::NoiseOn | Self::NoiseOff => 10.0,
            Self::ClockOffset => 30.0,
        }
    }
}

/// Name of the finding that no recording distinguishes from the one called `name`: an effect of the
/// catalogue for a parameter of the model, and the reverse. A delay of all pixels is an offset of
/// the clock.
pub(crate) fn same_as(name: &str) -> Option<&'static str> {
    let same = |spec: &&'static StageSpec| {
        let common = spec.search().same_as?;
        let parameter = ModelParameter::ALL.into_iter().find(|one| one.common() == common)?;
        Some((spec.name, parameter.name()))
    };
    STAGES.entries().iter().filter_map(same).find_map(|(effect, parameter)| match name {
        _ if name == effect => Some(parameter),
        _ if name == parameter => Some(effect),
        _ => None,
    })
}

/// `model` with the parameters of `given`.
pub(crate) fn with_given_parameters(model: &SensorConfig, given: &SensorConfig) -> SensorConfig {
    let mut model = model.clone();
    for parameter in ModelParameter::ALL {
        parameter.set(&mut model, parameter.value(given));
    }
    model
}
