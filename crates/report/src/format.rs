//! Values as text, in tables, charts and sentences.

use evpose_core::stats::interval::Interval;

/// A value with three significant digits.
pub fn short(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        "unknown".to_owned()
    } else if (99.5..1e6).contains(&size) {
        format!("{value:.0}")
    } else if size == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e6).contains(&size) {
        let decimals = (2 - size.log10().floor() as i32).clamp(0, 5) as usize;
        // Zeros at the end of a whole number are no decimals.
        let text = format!("{value:.decimals$}");
        let text = if text.contains('.') { text.trim_end_matches('0') } else { &text };
        text.trim_end_matches('.').to_owned()
    } else {
        format!("{value:.1e}")
    }
}

/// A share in percent.
pub fn percent(share: f64) -> String {
    if share.is_finite() { format!("{:.0}%", 100.0 * share) } else { "unknown".to_owned() }
}

/// A value with half the width of its interval; `-` where there is none.
pub fn with_interval_or_dash(interval: Option<&Interval>, digits: usize) -> String {
    interval.map_or_else(|| "-".to_owned(), |interval| with_interval(interval, digits))
}

/// A value with half the width of its interval, if it has one: `0.612 ± 0.013`.
pub fn with_interval(interval: &Interval, digits: usize) -> String {
    let estimate = interval.estimate;
    match interval.high {
        Some(high) => format!("{estimate:.digits$} ± {:.digits$}", high - estimate),
        None => format!("{estimate:.digits$}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_three_digits_and_no_idle_zeros() {
        let cases = [
            (0.0, "0"),
            (11.83, "11.8"),
            (1.3, "1.3"),
            (117.2, "117"),
            (0.0781, "0.0781"),
            (2.0, "2"),
            (100.0, "100"),
            (12_345.6, "12346"),
            (3.2e-5, "3.2e-5"),
            (f64::NAN, "unknown"),
        ];
        for (value, expected) in cases {
            assert_eq!(short(value), expected);
        }
    }
}
