//! What the registry knows about a stage: enough to parse it, list it, document it and fit it.

use std::fmt;

use crate::{SensorError, Settings, Signature, Stage};

/// Where in the camera a stage acts, in the order of the signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Domain {
    /// Luminance to irradiance: what the lens does.
    Optics,
    /// Irradiance to photocurrent.
    Photodiode,
    /// Photocurrent to log voltage.
    Photoreceptor,
    /// Log voltage to requests for an event.
    Detector,
    /// Requests that no change of light has caused.
    Background,
    /// Requests to events: who is served, and when.
    Readout,
    /// Event times to timestamps.
    Clock,
}

impl Domain {
    /// The name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Optics => "optics",
            Self::Photodiode => "photodiode",
            Self::Photoreceptor => "photoreceptor",
            Self::Detector => "detector",
            Self::Background => "background",
            Self::Readout => "readout",
            Self::Clock => "clock",
        }
    }
}

impl fmt::Display for Domain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The entry of one stage in the registry.
#[derive(Debug)]
pub struct StageSpec {
    /// The name in configurations and reports, and the key of the stage's noise.
    pub name: &'static str,
    /// Where it acts.
    pub domain: Domain,
    /// One sentence.
    pub summary: &'static str,
    /// What it does to its signal, in the names of its parameters.
    pub formula: &'static str,
    /// Its physical quantities.
    pub params: &'static [ParamSpec],
    /// Its variants.
    pub choices: &'static [ChoiceSpec],
    /// Its measurements.
    pub files: &'static [FileSpec],
    /// Where the model comes from.
    pub source: Citation,
    /// How it shows.
    pub signature: Signature,
    /// Makes the stage from checked settings.
    pub build: fn(&Settings) -> Result<Stage, SensorError>,
}

impl StageSpec {
    /// The keys that the stage takes in a configuration.
    pub fn keys(&self) -> Vec<&'static str> {
        let params = self.params.iter().map(|param| param.name);
        let choices = self.choices.iter().map(|choice| choice.name);
        params.chain(choices).chain(self.files.iter().map(|file| file.name)).collect()
    }
}

/// A physical quantity of a stage.
#[derive(Debug, Clone, PartialEq)]
pub struct ParamSpec {
    /// The key in configurations.
    pub name: &'static str,
    /// The unit in tables; empty for a pure number.
    pub unit: &'static str,
    /// The least and the greatest value, both allowed.
    pub range: (f64, f64),
    /// How values are compared and searched.
    pub scale: Scale,
    /// What is typical of cameras.
    pub prior: Prior,
    /// The value at which the quantity has no effect, allowed even outside the range. A quantity
    /// that has none must be given.
    pub neutral: Option<f64>,
    /// What it is.
    pub doc: &'static str,
}

impl ParamSpec {
    /// Whether a configuration may give this value.
    pub fn allows(&self, value: f64) -> bool {
        Some(value) == self.neutral || (self.range.0..=self.range.1).contains(&value)
    }

    /// The allowed values in words.
    pub fn expected(&self) -> String {
        let (low, high) = self.range;
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        match self.neutral {
            Some(neutral) if !(low..=high).contains(&neutral) => {
                format!("a number in {low}..={high}{unit} or {neutral} (no effect)")
            }
            _ => format!("a number in {low}..={high}{unit}"),
        }
    }

    /// The value a fraction of the way from `low` to `high`, on this parameter's scale.
    pub fn between(&self, (low, high): (f64, f64), fraction: f64) -> f64 {
        let value = match self.scale {
            Scale::Linear => low + (high - low) * fraction,
            Scale::Log => (low.ln() + (high / low).ln() * fraction).exp(),
        };
        // Rounding must not leave the range.
        value.clamp(low, high)
    }
}

/// Whether equal steps of a quantity are equal differences or equal ratios.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences.
    Linear,
    /// Equal ratios.
    Log,
}

/// What is known about a quantity before looking at data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prior {
    /// Cameras lie in this interval, evenly on the quantity's scale.
    Typical(f64, f64),
    /// A property of the recording or of a reference implementation, not to be fitted.
    Fixed,
}

/// A variant of a stage: one word out of a few. The first is the default.
#[derive(Debug, Clone, PartialEq)]
pub struct ChoiceSpec {
    /// The key in configurations.
    pub name: &'static str,
    /// The words allowed.
    pub allowed: &'static [&'static str],
    /// What they mean.
    pub doc: &'static str,
}

/// A measurement that a stage takes from a file: given as a path, without effect where left out.
#[derive(Debug, Clone, PartialEq)]
pub struct FileSpec {
    /// The key in configurations.
    pub name: &'static str,
    /// The unit of its values.
    pub unit: &'static str,
    /// What it holds.
    pub doc: &'static str,
}

/// A publication.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Citation {
    /// Authors and year, for tables.
    pub key: &'static str,
    /// Enough to find it.
    pub text: &'static str,
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: ParamSpec = ParamSpec {
        name: "rate",
        unit: "Hz",
        range: (0.01, 100.0),
        scale: Scale::Log,
        prior: Prior::Fixed,
        neutral: Some(0.0),
        doc: "",
    };

    #[test]
    fn the_neutral_value_is_allowed_outside_the_range() {
        assert!(RATE.allows(0.0) && RATE.allows(0.01) && RATE.allows(100.0));
        assert!(!RATE.allows(0.005) && !RATE.allows(-1.0) && !RATE.allows(f64::NAN));
        assert_eq!(RATE.expected(), "a number in 0.01..=100 Hz or 0 (no effect)");
    }

    #[test]
    fn halfway_on_a_log_scale_is_the_geometric_mean() {
        assert!((RATE.between((0.01, 100.0), 0.5) - 1.0).abs() < 1e-12);
    }
}
