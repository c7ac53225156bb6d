//! Ranges of numeric arguments, and choices of others: a value that no command could work with is refused before anything
//! begins.
//!
//! Bounds are far beyond use and well within what integers of microseconds, durations and memory hold.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Longest time in seconds: eleven days.
pub const MAX_SECONDS: f64 = 1e6;
/// Most threads: beyond any machine, and well below what an operating system refuses.
pub const MAX_THREADS: usize = 1_024;

/// A parser of values within `range`: neither NaN nor infinity is one.
pub fn within<T>(
    range: RangeInclusive<T>,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: FromStr + PartialOrd + Display + Clone + Send + Sync + 'static,
{
    move |text| {
        let value = text.parse().ok().filter(|value| range.contains(value));
        value.ok_or_else(|| format!("expected a number from {} to {}", range.start(), range.end()))
    }
}

/// A duration in seconds, from a microsecond to [`MAX_SECONDS`].
pub fn seconds() -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    within(1e-6..=MAX_SECONDS)
}

/// A time in seconds since the first event, or a duration that may be zero, up to [`MAX_SECONDS`].
pub fn since_start() -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    within(0.0..=MAX_SECONDS)
}

/// A duration in milliseconds, from a microsecond to a quarter of an hour, the longest window of a representation.
pub fn milliseconds() -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    within(1e-3..=1e6)
}

/// Times per second, from one in a quarter of an hour to a million.
pub fn hertz() -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    within(1e-3..=1e6)
}

/// 0 for none, or a number that `parse` takes.
pub fn zero_or<F>(parse: F) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static
where
    F: Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static,
{
    move |text| match text.parse() {
        Ok(0.0) => Ok(0.0),
        _ => parse(text).map_err(|expected| format!("{expected}, or 0")),
    }
}

/// A share or score from 0 to 1.
pub fn share() -> impl Fn(&str) -> Result<f32, String> + Clone + Send + Sync + 'static {
    within(0.0..=1.0)
}

/// One of these values by its name, which help lists with what it means.
pub(crate) fn choices<T, const N: usize>(
    choices: [(&'static str, &'static str, T); N],
) -> impl TypedValueParser<Value = T>
where
    T: Copy + Send + Sync + 'static,
{
    let names = choices.map(|(name, help, _)| PossibleValue::new(name).help(help));
    PossibleValuesParser::new(names).map(move |name| {
        let chosen = choices.iter().find(|choice| choice.0 == name);
        chosen.unwrap_or_else(|| unreachable!("`{name}` is none of the possible values")).2
    })
}

/// A thread count from 1 to [`MAX_THREADS`].
pub fn threads() -> impl Fn(&str) -> Result<usize, String> + Clone + Send + Sync + 'static {
    within(1..=MAX_THREADS)
}

/// A count from 1 to a million.
pub fn count<T>() -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: FromStr + PartialOrd + Display + Clone + Send + Sync + From<u8> + TryFrom<u32> + 'static,
{
    // What does not hold a million is an integer of bytes, whose largest value serves.
    let most = T::try_from(1_000_000).unwrap_or_else(|_| T::from(u8::MAX));
    within(T::from(1)..=most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_of_the_range_is_refused() {
        for text in ["-1", "0", "NaN", "inf", "-inf", "1e308", "1e-308", "", "x"] {
            let refused = seconds()(text).expect_err(text);
            assert_eq!(refused, "expected a number from 0.000001 to 1000000", "{text}");
        }
        assert_eq!((seconds()("1e6"), since_start()("0")), (Ok(1e6), Ok(0.0)));
        assert!(threads()("100000").is_err() && threads()("0").is_err());
        assert_eq!((count::<u32>()("1000000"), count::<usize>()("7")), (Ok(1_000_000), Ok(7)));
        assert!(count::<u64>()("9223372036854775807").is_err());
    }
}
