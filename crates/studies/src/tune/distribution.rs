//! How one parameter is drawn.

use anyhow::{Result, bail, ensure};
use evpose_core::CounterRng;
use toml::Value;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Distribution {
    /// Its logarithm is uniform between those of two positive bounds.
    LogUniform(f64, f64),
    /// Uniform between two bounds.
    Uniform(f64, f64),
    /// A whole number, uniform between two bounds, both included.
    Integer(i64, i64),
    /// One of these, each as likely.
    Choose(Vec<Value>),
}

/// Significant digits of drawn floating-point values: as many as a reader wants to copy.
const DIGITS: i32 = 4;

impl Distribution {
    pub(crate) const NAMES: [&str; 4] = ["log_uniform", "uniform", "integer", "choose"];

    pub(crate) fn read(name: &str, array: &[Value]) -> Result<Self> {
        if name == "choose" {
            ensure!(!array.is_empty(), "`choose` needs at least one value");
            return Ok(Self::Choose(array.to_vec()));
        }
        let [low, high] = array else { bail!("`{name}` takes [low, high]") };
        if name == "integer" {
            return match (low.as_integer(), high.as_integer()) {
                // The span has to fit into 64 bits as well.
                (Some(low), Some(high)) if low <= high && high.checked_sub(low).is_some() => {
                    Ok(Self::Integer(low, high))
                }
                _ => bail!("`integer` takes two whole numbers, the lower first"),
            };
        }
        let real = |value: &Value| value.as_float().or(value.as_integer().map(|v| v as f64));
        let (low, high) = match (real(low), real(high)) {
            (Some(low), Some(high)) if low < high && low.is_finite() && high.is_finite() => {
                (low, high)
            }
            _ => bail!("`{name}` takes two finite values, the lower first"),
        };
        match name {
            "uniform" => Ok(Self::Uniform(low, high)),
            // A logarithm has no value at zero.
            "log_uniform" if low > 0.0 => Ok(Self::LogUniform(low, high)),
            "log_uniform" => bail!("`log_uniform` takes positive values"),
            _ => bail!("no such distribution; there are {}", Self::NAMES.join(", ")),
        }
    }

    /// The next value of a stream of random bits.
    pub(crate) fn draw(&self, rng: &mut CounterRng) -> Value {
        let bits = rng.bits();
        // 53 bits, in [0, 1).
        let share = (bits >> 11) as f64 / (1u64 << 53) as f64;
        match self {
            Self::LogUniform(low, high) => {
                let value = (low.ln() + share * (high.ln() - low.ln())).exp();
                // Rounding may leave the range by half a digit, hence the clamp.
                Value::Float(rounded(value).clamp(*low, *high))
            }
            Self::Uniform(low, high) => {
                Value::Float(rounded(low + share * (high - low)).clamp(*low, *high))
            }
            Self::Integer(low, high) => {
                // The remainder prefers low values by at most one part in 2^64 / count.
                let count = high.abs_diff(*low) + 1;
                Value::Integer(low.saturating_add_unsigned(bits % count))
            }
            Self::Choose(values) => values[(bits % values.len() as u64) as usize].clone(),
        }
    }

    /// Its lowest and its highest value, or all that it chooses from.
    pub(crate) fn extremes(&self) -> Vec<Value> {
        match self {
            Self::LogUniform(low, high) | Self::Uniform(low, high) => {
                vec![Value::Float(*low), Value::Float(*high)]
            }
            Self::Integer(low, high) => vec![Value::Integer(*low), Value::Integer(*high)],
            Self::Choose(values) => values.clone(),
        }
    }

    /// Whether a chart of its values has a logarithmic axis.
    pub(crate) fn is_log(&self) -> bool {
        matches!(self, Self::LogUniform(..))
    }
}

/// The value to a few significant digits.
fn rounded(value: f64) -> f64 {
    // By way of decimals: powers of ten below one are not exact.
    format!("{value:.*e}", (DIGITS - 1) as usize).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn array(text: &str) -> Vec<Value> {
        let mut table: toml::Table = toml::from_str(&format!("v = {text}")).unwrap();
        let Some(Value::Array(array)) = table.remove("v") else { panic!("{text}") };
        array
    }

    fn read(name: &str, text: &str) -> Result<Distribution> {
        Distribution::read(name, &array(text))
    }

    fn draws(distribution: &Distribution, count: u64) -> Vec<Value> {
        (0..count).map(|i| distribution.draw(&mut CounterRng::new(1, "test", i))).collect()
    }

    #[test]
    fn draws_cover_their_range_evenly() {
        let floats = |distribution: &Distribution| -> Vec<f64> {
            draws(distribution, 4000).iter().map(|value| value.as_float().unwrap()).collect()
        };
        let log = floats(&read("log_uniform", "[1e-4, 1e-2]").unwrap());
        assert!(log.iter().all(|v| (1e-4..=1e-2).contains(v)));
        // Half of them below the geometric mean.
        let below = log.iter().filter(|v| **v < 1e-3).count() as f64 / 4000.0;
        assert!((below - 0.5).abs() < 0.03, "{below}");
        let uniform = floats(&read("uniform", "[2, 4]").unwrap());
        let mean = uniform.iter().sum::<f64>() / 4000.0;
        assert!((mean - 3.0).abs() < 0.03, "{mean}");
        let integer = draws(&read("integer", "[-1, 2]").unwrap(), 4000);
        for wanted in -1..=2 {
            let share = integer.iter().filter(|v| v.as_integer() == Some(wanted)).count();
            assert!((900..1100).contains(&share), "{wanted}: {share}");
        }
        let chosen = draws(&read("choose", "[\"a\", true]").unwrap(), 400);
        assert!(chosen.iter().filter(|v| v.as_str() == Some("a")).count() > 150);
    }

    #[test]
    fn drawn_values_are_short_enough_to_copy() {
        assert_eq!(rounded(0.001_234_56), 0.001_235);
        assert_eq!(rounded(123_456.0), 123_500.0);
    }

    #[test]
    fn an_array_that_is_no_range_is_refused_in_words() {
        for (name, text, part) in [
            ("log_uniform", "[0, 1]", "positive"),
            ("uniform", "[2, 1]", "the lower first"),
            ("uniform", "[1]", "[low, high]"),
            ("integer", "[1.5, 2]", "whole"),
            ("choose", "[]", "at least one"),
            ("normal", "[0, 1]", "log_uniform, uniform, integer, choose"),
        ] {
            let message = read(name, text).unwrap_err().to_string();
            assert!(message.contains(part), "{name} = {text}: {message}");
        }
    }
}
