//! Parameters of effects, cleaners and representations: keys, the values that they take, defaults.

mod settings;

pub use settings::{Given, ParameterError, Setting, Settings};

/// A parameter: a number, one word out of a few, a file, or text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Parameter {
    /// A number.
    Number(NumberSpec),
    /// A word.
    Word(WordSpec),
    /// A file, which may be left out.
    File(FileSpec),
    /// Text, which may be left out.
    Text(TextSpec),
}

impl Parameter {
    /// The key in configurations.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Number(spec) => spec.name,
            Self::Word(spec) => spec.name,
            Self::File(spec) => spec.name,
            Self::Text(spec) => spec.name,
        }
    }

    /// Description.
    pub const fn doc(&self) -> &'static str {
        match self {
            Self::Number(spec) => spec.doc,
            Self::Word(spec) => spec.doc,
            Self::File(spec) => spec.doc,
            Self::Text(spec) => spec.doc,
        }
    }

    /// The allowed values in words.
    pub fn expected(&self) -> String {
        match self {
            Self::Number(spec) => spec.expected(),
            Self::Word(spec) => format!("one of {}", spec.allowed.join(", ")),
            Self::File(_) => "the path of a file".to_owned(),
            Self::Text(spec) => format!("text such as {:?}", spec.example),
        }
    }

    /// The specification of a number.
    pub const fn as_number(&self) -> Option<&NumberSpec> {
        if let Self::Number(spec) = self { Some(spec) } else { None }
    }

    /// The specification of a word.
    pub const fn as_word(&self) -> Option<&WordSpec> {
        if let Self::Word(spec) = self { Some(spec) } else { None }
    }

    /// The specification of a file.
    pub const fn as_file(&self) -> Option<&FileSpec> {
        if let Self::File(spec) = self { Some(spec) } else { None }
    }

    /// The specification of a text.
    pub const fn as_text(&self) -> Option<&TextSpec> {
        if let Self::Text(spec) = self { Some(spec) } else { None }
    }
}

impl AsRef<str> for Parameter {
    fn as_ref(&self) -> &str {
        self.name()
    }
}

/// A number: a physical quantity, a ratio, a count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NumberSpec {
    /// The key in configurations.
    pub name: &'static str,
    /// The unit in tables; empty for a pure number.
    pub unit: &'static str,
    /// Whole, odd or any values.
    pub kind: NumberKind,
    /// The least and the greatest value, both allowed.
    pub range: (f64, f64),
    /// The comparison of values.
    pub scale: Scale,
    /// The interval in which values of cameras lie, evenly on the scale. None for a property of the
    /// recording or of a reference implementation, which is not to be fitted.
    pub typical: Option<(f64, f64)>,
    /// The value where none is given. Of an effect, the value at which it does nothing; that may
    /// lie outside the range and is allowed nevertheless.
    pub default: Option<f64>,
    /// Of an effect: it has one whatever the values of those parameters that make it stronger.
    pub acts_alone: bool,
    /// Description.
    pub doc: &'static str,
}

impl NumberSpec {
    /// The base of specifications on a linear scale: a real number without unit, typical values
    /// and default.
    pub const LINEAR: Self = Self {
        name: "",
        unit: "",
        kind: NumberKind::Real,
        range: (f64::NEG_INFINITY, f64::INFINITY),
        scale: Scale::Linear,
        typical: None,
        default: None,
        acts_alone: false,
        doc: "",
    };
    /// The same on a logarithmic scale.
    pub const LOG: Self = Self { scale: Scale::Log, ..Self::LINEAR };

    /// Whether a configuration may give this value.
    pub fn allows(&self, value: f64) -> bool {
        let is_in_range = (self.range.0..=self.range.1).contains(&value);
        Some(value) == self.default || (is_in_range && self.kind.contains(value))
    }

    /// The allowed values in words.
    fn expected(&self) -> String {
        let Self { unit, kind, range: (low, high), .. } = self;
        let space = if unit.is_empty() { "" } else { " " };
        let within = format!("{} in {low}..={high}{space}{unit}", kind.words());
        match self.default {
            Some(default) if !(*low..=*high).contains(&default) => {
                format!("{within} or {default} (no effect)")
            }
            _ => within,
        }
    }

    /// The value a fraction of the way from `low` to `high`, on this number's scale.
    pub fn between(&self, (low, high): (f64, f64), fraction: f64) -> f64 {
        let value = match self.scale {
            Scale::Linear => low + (high - low) * fraction,
            Scale::Log => (low.ln() + (high / low).ln() * fraction).exp(),
        };
        // Rounding must not leave the range.
        value.clamp(low, high)
    }
}

/// Values that a parameter takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NumberKind {
    /// Any number.
    Real,
    /// Integers.
    Whole,
    /// Odd integers.
    Odd,
    /// Even integers.
    Even,
}

impl NumberKind {
    /// The kind in words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Real => "a number",
            Self::Whole => "a whole number",
            Self::Odd => "an odd number",
            Self::Even => "an even number",
        }
    }

    fn contains(self, value: f64) -> bool {
        let rest = match self {
            Self::Real => 0.0,
            Self::Whole => value.rem_euclid(1.0),
            Self::Odd => (value - 1.0).rem_euclid(2.0),
            Self::Even => value.rem_euclid(2.0),
        };
        rest == 0.0
    }
}

/// Whether equal steps of a number are equal differences or equal ratios.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences.
    Linear,
    /// Equal ratios.
    Log,
}

/// One word out of a few.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WordSpec {
    /// The key in configurations.
    pub name: &'static str,
    /// The words allowed.
    pub allowed: &'static [&'static str],
    /// The word where none is given; none if it may be left out.
    pub default: Option<&'static str>,
    /// Their meaning.
    pub doc: &'static str,
}

/// A file, given as its path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FileSpec {
    /// The key in configurations.
    pub name: &'static str,
    /// The unit of its values; empty if they have none.
    pub unit: &'static str,
    /// Content of the file, for lists.
    pub doc: &'static str,
}

/// Text, which its owner reads and checks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TextSpec {
    /// The key in configurations.
    pub name: &'static str,
    /// A text that is allowed.
    pub example: &'static str,
    /// Content of the text, for lists.
    pub doc: &'static str,
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: NumberSpec = NumberSpec {
        name: "rate",
        unit: "Hz",
        range: (0.01, 100.0),
        default: Some(0.0),
        ..NumberSpec::LOG
    };

    #[test]
    fn the_default_is_allowed_outside_the_range() {
        assert!(RATE.allows(0.0) && RATE.allows(0.01) && RATE.allows(100.0));
        assert!(!RATE.allows(0.005) && !RATE.allows(-1.0) && !RATE.allows(f64::NAN));
        assert_eq!(RATE.expected(), "a number in 0.01..=100 Hz or 0 (no effect)");
    }

    #[test]
    fn halfway_on_a_log_scale_is_the_geometric_mean() {
        assert!((RATE.between((0.01, 100.0), 0.5) - 1.0).abs() < 1e-12);
    }
}
