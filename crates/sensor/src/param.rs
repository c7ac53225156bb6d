//! Parameters, choices and files that a stage takes in a configuration.

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
    /// Typical values of cameras.
    pub prior: Prior,
    /// The value at which the quantity has no effect, allowed even outside the range. A quantity
    /// that has none must be given.
    pub neutral: Option<f64>,
    /// Description.
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

/// Prior knowledge of a quantity.
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
    /// Their meaning.
    pub doc: &'static str,
}

/// A measurement that a stage takes from a file: given as a path, without effect where left out.
#[derive(Debug, Clone, PartialEq)]
pub struct FileSpec {
    /// The key in configurations.
    pub name: &'static str,
    /// The unit of its values.
    pub unit: &'static str,
    /// Its content.
    pub doc: &'static str,
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
