//! A formula of a corrected model, for the verdict.

use evpose_sensor::{EffectConfig, Value, formula_curve};

use crate::search::Term;
use crate::verdict::FoundFormula;

/// Points of a curve.
const POINTS: usize = 21;

/// The formula of an effect with its values, its curve and its reading; none if it is none of the terms
/// that are tried.
pub(super) fn found_formula(effect: &EffectConfig) -> Option<FoundFormula> {
    let term = Term::of(effect)?;
    let (low, high) = range(term.variable);
    let x = (0..POINTS).map(|k| low + (high - low) * k as f64 / (POINTS - 1) as f64);
    let x: Vec<f64> = if term.variable.is_empty() { vec![0.0] } else { x.collect() };
    let y = formula_curve(effect, term.variable, &x).ok()?;
    Some(FoundFormula {
        stage: term.stage.to_owned(),
        expression: with_values(term.expression, effect),
        variable: term.variable.to_owned(),
        curve: x.into_iter().zip(y).map(|(x, y)| [x, y]).collect(),
        reading: reading(term, effect),
    })
}

/// A possible cause of a formula, and whether its constants may be others than these.
fn reading(term: &Term, effect: &EffectConfig) -> String {
    match term.at_an_end(effect).as_slice() {
        [] => term.reading.to_owned(),
        names => format!(
            "{} ({} at an end of what is tried: the best value may lie beyond)",
            term.reading,
            names.join(" and ")
        ),
    }
}

/// Values of a variable between which a curve shows what there is to see.
fn range(variable: &str) -> (f64, f64) {
    match variable {
        "age_ms" | "neighbour_age_ms" => (0.0, 100.0),
        "polarity" => (-1.0, 1.0),
        "pixel" | "patch" | "column_noise" | "row_noise" => (-2.0, 2.0),
        _ => (0.0, 1.0),
    }
}

/// A formula with the values of its constants, of three digits, in their places.
fn with_values(expression: &str, effect: &EffectConfig) -> String {
    let mut written = String::new();
    let mut rest = expression;
    while let Some(first) = rest.chars().next() {
        let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let len = rest.find(|c| !is_part(c)).unwrap_or(rest.len()).max(first.len_utf8());
        let (word, behind) = rest.split_at(len);
        match effect.params.get(word) {
            Some(Value::Number(value)) => {
                let exponent = value.abs().max(1e-9).log10().floor() as i32;
                let digits = usize::try_from(2 - exponent).unwrap_or(0);
                let value = format!("{value:.digits$}");
                // A sign would stand beside another one.
                written += &if value.starts_with('-') { format!("({value})") } else { value };
            }
            _ => written += word,
        }
        rest = behind;
    }
    written
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_formula_is_written_with_its_values_and_drawn() {
        let effect = EffectConfig::new("formula").with("stage", "threshold");
        let effect = effect.with("expression", "1 + a*exp(-age_ms/b)").with("a", -0.2134);
        let at_an_end = found_formula(&effect.clone().with("b", 299.0)).unwrap();
        assert!(
            at_an_end
                .reading
                .ends_with("(b at an end of what is tried: the best value may lie beyond)")
        );
        let found = found_formula(&effect.with("b", 31.27)).unwrap();
        assert_eq!(found.expression, "1 + (-0.213)*exp(-age_ms/31.3)");
        assert_eq!(found.variable, "age_ms");
        assert!(!found.reading.contains("at an end"), "{}", found.reading);
        assert!((found.curve[0][1] - 0.7866).abs() < 1e-6);
        let (x, y) = (found.curve[20][0], found.curve[20][1]);
        assert!(x == 100.0 && (y - (1.0 - 0.2134 * f64::exp(-100.0 / 31.27))).abs() < 1e-6);
    }
}
