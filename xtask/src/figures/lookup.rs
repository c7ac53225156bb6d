//! A value of a stored result, by its path, and its text.

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

/// The value at a path: steps between slashes, each a field, an index, or `field=value`, the element of an
/// array with that value (`a=x&b=2` with both). Absent values and null are none.
pub(super) fn value<'a>(root: &'a Value, path: &str) -> Option<&'a Value> {
    let found =
        path.split('/').filter(|step| !step.is_empty()).try_fold(root, |at, step| match at {
            Value::Object(fields) => fields.get(step),
            Value::Array(elements) if step.contains('=') => {
                elements.iter().find(|element| is_meant(element, step))
            }
            Value::Array(elements) => elements.get(step.parse::<usize>().ok()?),
            _ => None,
        });
    found.filter(|value| !value.is_null())
}

/// Whether an element has all values of a step.
fn is_meant(element: &Value, step: &str) -> bool {
    step.split('&').filter_map(|condition| condition.split_once('=')).all(|(field, wanted)| {
        // The step is text, but the field may hold an integer.
        let found = &element[field];
        found == wanted || wanted.parse().is_ok_and(|wanted: i64| found.as_i64() == Some(wanted))
    })
}

/// How a number is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Format {
    /// The factor of the written value.
    factor: f64,
    digits: usize,
}

impl Format {
    /// `.2` has two digits behind the point, `%` and `%.1` are per cent, `M.0` millions, `m.0` thousandths.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let (factor, rest) = match text.chars().next()? {
            '%' if text == "%" => (100.0, ".0"),
            '%' => (100.0, &text[1..]),
            'M' => (1e-6, &text[1..]),
            'm' => (1e3, &text[1..]),
            _ => (1.0, text),
        };
        let digits = rest.strip_prefix('.')?.parse().ok()?;
        Some(Self { factor, digits })
    }

    pub(super) fn number(self, value: f64) -> Result<String> {
        ensure!(value.is_finite(), "a value that is not finite");
        Ok(format!("{:.*}", self.digits, self.factor * value))
    }
}

/// The text of a value: of a number in its format, of an interval with both of its ends, else as it is.
pub(super) fn text(value: &Value, format: Option<Format>) -> Result<String> {
    match (value, format) {
        (Value::String(text), None) => Ok(text.clone()),
        // An integer is exact, so that only fractions need a format.
        (Value::Number(number), None) if !number.is_f64() => Ok(number.to_string()),
        (Value::Number(number), Some(format)) => {
            format.number(number.as_f64().context("a number")?)
        }
        (Value::Object(interval), Some(format)) => {
            let part = |name: &str| {
                let number = interval.get(name).and_then(Value::as_f64);
                format.number(number.with_context(|| format!("an interval without `{name}`"))?)
            };
            Ok(format!("{} [{}, {}]", part("estimate")?, part("low")?, part("high")?))
        }
        _ => bail!("{value} needs a format, or is none of text, number and interval"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stored() -> Value {
        serde_json::json!({ "cases": [
            { "work": "a, 1 thread", "ms": 2.345, "runs": 7, "peer": null },
            { "work": "a, 2 threads", "ratio": { "estimate": 1.98, "low": 1.9, "high": 2.0 } },
        ] })
    }

    #[test]
    fn values_are_found_by_field_index_and_name() {
        let root = stored();
        let of = |path| value(&root, path).map(Value::to_string);
        assert_eq!(of("cases/work=a, 1 thread/ms"), Some("2.345".into()));
        assert_eq!(of("/cases/0/runs"), Some("7".into()));
        assert_eq!(of("cases/work=a, 1 thread&runs=7/runs"), Some("7".into()));
        assert_eq!(of("cases/work=a, 1 thread&runs=8/runs"), None);
        for missing in ["cases/work=b/ms", "cases/2", "cases/0/peer", "none"] {
            assert_eq!(of(missing), None, "{missing}");
        }
    }

    #[test]
    fn values_have_their_format_and_intervals_their_ends() {
        let written = |value: &Value, format| text(value, Format::parse(format)).ok();
        let root = stored();
        let interval = value(&root, "cases/1/ratio").expect("an interval");
        assert_eq!(written(interval, ".2"), Some("1.98 [1.90, 2.00]".into()));
        assert_eq!(written(&0.7829.into(), "%"), Some("78".into()));
        assert_eq!(written(&0.7829.into(), "%.1"), Some("78.3".into()));
        assert_eq!(written(&5_040_000.into(), "M.1"), Some("5.0".into()));
        assert_eq!(written(&0.00729.into(), "m.1"), Some("7.3".into()));
        assert_eq!(written(&7.into(), ""), Some("7".into()));
        assert_eq!(written(&0.5.into(), ""), None, "digits are stated");
    }
}
