//! An effect at several strengths, for tables and pages.

use crate::NumberSpec;
use crate::chain_table::quantity;
use crate::effect::EffectConfig;
use crate::signature::Strength;
use crate::spec::StageSpec;

/// One setting of an effect among others.
#[derive(Debug, Clone, PartialEq)]
pub struct StrengthLevel {
    /// In a word.
    pub label: &'static str,
    /// The effect with all its parameters.
    pub effect: EffectConfig,
    /// The difference of the levels, as `name = value unit`.
    pub values: String,
}

impl StageSpec {
    /// The effect in the middle of what is typical of cameras. What is no property of a camera is
    /// left out, or in the middle of its range where it must be given.
    pub fn typical(&self) -> EffectConfig {
        let mut effect = EffectConfig::new(self.name);
        for param in self.number_params() {
            if param.typical.is_some() || param.default.is_none() {
                effect = effect.with(param.name, at(param, 0.5));
            }
        }
        effect
    }

    /// The effect at a weak, a typical and a strong setting: the ends and the middle of what is
    /// typical of cameras, or, for what is no property of a camera, the quarters of its range.
    /// Where a parameter has two signs, its two ends and half of the positive one. None where files
    /// say all.
    pub fn strength_levels(&self) -> Vec<StrengthLevel> {
        let (names, is_rising) = match self.signature.strength {
            Strength::Rising(names) | Strength::RisingAlone(names) => (names, true),
            Strength::Falling(names) => (names, false),
            Strength::Unchanging => {
                let (label, effect) = ("as it is", self.typical());
                return vec![StrengthLevel { label, effect, values: "no parameters".to_owned() }];
            }
            Strength::FromFiles => return Vec::new(),
        };
        let params: Vec<&NumberSpec> =
            self.number_params().filter(|param| names.contains(&param.name)).collect();
        // The middle of a signed range is near no effect at all: half of the positive end shows
        // one.
        let is_signed = params.iter().any(|param| half_positive(param).is_some());
        let is_fixed = params.iter().any(|param| param.typical.is_none());
        let mut steps = match (is_signed, is_fixed) {
            (true, _) => [("negative", Some(0.0)), ("half", None), ("positive", Some(1.0))],
            (_, true) => [("weak", Some(0.25)), ("middle", Some(0.5)), ("strong", Some(0.75))],
            (_, false) => [("weak", Some(0.0)), ("typical", Some(0.5)), ("strong", Some(1.0))],
        };
        // A falling parameter is strongest at its low end.
        if !is_rising && !is_signed {
            steps = steps.map(|(label, share)| (label, share.map(|share| 1.0 - share)));
        }
        let level = |(label, share)| {
            // Alone: typical values of its other parameters would hide this one's effect.
            let mut effect = match self.signature.strength {
                Strength::RisingAlone(_) => EffectConfig::new(self.name),
                _ => self.typical(),
            };
            let mut values = Vec::new();
            for param in &params {
                let value = match share {
                    Some(share) => at(param, share),
                    None => half_positive(param).unwrap_or_else(|| at(param, 0.5)),
                };
                values.push(format!("{} = {}", param.name, quantity(param, value)));
                effect = effect.with(param.name, value);
            }
            StrengthLevel { label, effect, values: values.join(", ") }
        };
        steps.map(level).into()
    }
}

/// A fraction of the way through what is typical, or through the range where nothing is; three
/// digits of it.
fn at(param: &NumberSpec, share: f64) -> f64 {
    let value = param.between(param.typical.unwrap_or(param.range), share);
    let rounded = format!("{value:.2e}").parse().unwrap_or(value);
    rounded.clamp(param.range.0, param.range.1)
}

/// Half of the positive end of what is typical, of a quantity that has two signs.
fn half_positive(param: &NumberSpec) -> Option<f64> {
    param.typical.filter(|(low, high)| *low < 0.0 && *high > 0.0).map(|(_, high)| high / 2.0)
}

#[cfg(test)]
mod tests {
    use crate::{STAGES, SensorConfig, SensorModel};

    #[test]
    fn every_effect_is_a_sensor_at_every_strength() {
        for spec in &STAGES {
            let beside = spec.signature.beside.iter().map(|name| {
                let other = STAGES.find(name);
                other.unwrap_or_else(|| panic!("{}: no effect {name}", spec.name)).typical()
            });
            let beside: Vec<_> = beside.collect();
            for level in spec.strength_levels() {
                let mut config = SensorConfig { effects: beside.clone() };
                config.effects.push(level.effect);
                let model = SensorModel::from_config(&config);
                let model = model.unwrap_or_else(|error| panic!("{}: {error}", spec.name));
                let rows = &model.describe().rows;
                let row = rows.iter().find(|row| row.spec.name == spec.name).unwrap();
                // The clock of a good camera counts microseconds, as streams do.
                let is_active = row.is_active || level.label == "weak";
                assert!(is_active, "{} has no effect at {}", spec.name, level.values);
            }
        }
    }

    #[test]
    fn strengths_are_the_ends_and_the_middle_of_the_prior() {
        let values = |name: &str| -> Vec<String> {
            let spec = STAGES.find(name).unwrap();
            spec.strength_levels().into_iter().map(|level| level.values).collect()
        };
        assert_eq!(values("leak_on"), ["rate_hz = 0.01 Hz", "rate_hz = 0.1 Hz", "rate_hz = 1 Hz"]);
        assert_eq!(values("source_follower")[2], "cutoff_hz = 100 Hz");
        assert_eq!(values("lens_distortion"), ["k1 = -0.3", "k1 = 0.05", "k1 = 0.1"]);
    }
}
