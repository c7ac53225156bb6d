//! Numbers that the model has anyway. What moving them removes is a parameter that was set wrong,
//! not an effect that is missing.

use evpose_sensor::{EffectConfig, SensorConfig};
use serde::Serialize;

/// One number of the model that is fitted before and beside effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Parameter {
    /// ON threshold, fitted as a ratio.
    ThresholdOn,
    /// OFF threshold, fitted as a ratio.
    ThresholdOff,
    /// ON events of the background per pixel and second.
    NoiseOn,
    /// OFF events of the background per pixel and second.
    NoiseOff,
    /// What the clock of the recording is late, microseconds.
    ClockOffset,
}

impl Parameter {
    /// All of them.
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

    /// The effect and its key that hold the number.
    fn place(self) -> (&'static str, &'static str) {
        match self {
            Self::ThresholdOn => ("level_crossing", "threshold_on"),
            Self::ThresholdOff => ("level_crossing", "threshold_off"),
            Self::NoiseOn => ("uniform_noise", "on_hz"),
            Self::NoiseOff => ("uniform_noise", "off_hz"),
            Self::ClockOffset => ("clock_offset_drift", "offset_us"),
        }
    }

    /// The value in a model.
    pub fn value(self, model: &SensorConfig) -> f64 {
        let (effect, key) = self.place();
        model.effect(effect).and_then(|effect| effect.number(key)).unwrap_or(0.0)
    }

    /// Sets the value in a model, to which the effect is added where it is missing.
    pub fn set(self, model: &mut SensorConfig, value: f64) {
        let (name, key) = self.place();
        if matches!(self, Self::ThresholdOn | Self::ThresholdOff) && value <= 0.0 {
            // The model has another detector, of which this is no number.
            return;
        }
        let value = match self {
            // Stages take no rate that is positive but below their range: that is none.
            Self::NoiseOn | Self::NoiseOff if value < 1e-4 => 0.0,
            Self::ThresholdOn | Self::ThresholdOff => value.clamp(0.01, 5.0),
            _ => value,
        };
        if model.effect(name).is_none() {
            if value == 0.0 {
                return;
            }
            model.effects.push(EffectConfig::new(name));
        }
        for effect in model.effects.iter_mut().filter(|effect| effect.name == name) {
            *effect = effect.clone().with(key, value);
        }
        // Background and clock that do nothing are not worth a line in a model.
        let is_idle = |effect: &EffectConfig| {
            matches!(name, "uniform_noise" | "clock_offset_drift")
                && effect.name == name
                && effect.params.keys().all(|key| effect.number(key) == Some(0.0))
        };
        model.effects.retain(|effect| !is_idle(effect));
    }

    /// The value a number of steps away, a step being what shows well in a summary.
    pub fn stepped(self, value: f64, steps: f64) -> f64 {
        match self {
            Self::ThresholdOn | Self::ThresholdOff => value * (0.03 * steps).exp(),
            // The square root of a rate moves evenly in counts.
            Self::NoiseOn | Self::NoiseOff => {
                let root = value.sqrt() + 0.1 * steps;
                if root > 0.0 { root * root } else { 0.0 }
            }
            Self::ClockOffset => (value + 100.0 * steps).clamp(-1e5, 1e5),
        }
    }

    /// Steps from one value to another.
    pub fn steps(self, from: f64, to: f64) -> f64 {
        match self {
            Self::ThresholdOn | Self::ThresholdOff => (to / from).ln() / 0.03,
            Self::NoiseOn | Self::NoiseOff => (to.sqrt() - from.sqrt()) / 0.1,
            Self::ClockOffset => (to - from) / 100.0,
        }
    }

    /// Standard deviation, in steps, of what is likely before looking at data.
    pub fn prior_steps(self) -> f64 {
        match self {
            Self::ThresholdOn | Self::ThresholdOff => 10.0,
            Self::NoiseOn | Self::NoiseOff => 10.0,
            Self::ClockOffset => 30.0,
        }
    }
}

/// A model with the numbers that `given` has anyway.
pub(crate) fn with_given_numbers(model: &SensorConfig, given: &SensorConfig) -> SensorConfig {
    let mut model = model.clone();
    for parameter in Parameter::ALL {
        parameter.set(&mut model, parameter.value(given));
    }
    model
}
