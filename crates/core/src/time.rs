//! Integer microseconds and half-open windows of them.

use std::fmt;
use std::ops::{Add, Sub};

use serde::{Deserialize, Serialize};

/// A time or a duration in microseconds.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[serde(transparent)]
#[repr(transparent)]
pub struct Micros(pub i64);

impl Micros {
    /// One millisecond, the frame of the published simulator.
    pub const MILLISECOND: Self = Self(1_000);
    /// One second.
    pub const SECOND: Self = Self(1_000_000);

    /// The nearest microsecond to `seconds`.
    pub fn from_seconds(seconds: f64) -> Self {
        Self((seconds * 1e6).round() as i64)
    }

    /// This time in seconds.
    pub fn as_seconds(self) -> f64 {
        self.0 as f64 * 1e-6
    }
}

impl Add for Micros {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Sub for Micros {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl fmt::Display for Micros {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} µs", self.0)
    }
}

/// A half-open interval of time: `start` belongs to it, `end` does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimeWindow {
    /// First instant inside the window.
    pub start: Micros,
    /// First instant after the window.
    pub end: Micros,
}

impl TimeWindow {
    /// `end - start`.
    pub fn length(self) -> Micros {
        self.end - self.start
    }

    /// Whether `t` lies inside.
    pub fn contains(self, t: Micros) -> bool {
        self.start <= t && t < self.end
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_window_is_as_long_as_asked_for_and_ends_before_its_end(
            end in -1_000i64..1_000, length in 0i64..1_000, t in -2_000i64..2_000,
        ) {
            let window = TimeWindow { start: Micros(end - length), end: Micros(end) };
            prop_assert_eq!(window.length(), Micros(length));
            prop_assert_eq!(window.contains(Micros(t)), (end - length..end).contains(&t));
        }

        #[test]
        fn sums_undo_differences_and_seconds_are_a_million_microseconds(
            a in -1_000_000_000i64..1_000_000_000, b in -1_000_000_000i64..1_000_000_000,
        ) {
            prop_assert_eq!((Micros(a) + Micros(b)) - Micros(b), Micros(a));
            prop_assert_eq!(Micros(a) - Micros(0), Micros(a));
            prop_assert_eq!(Micros::from_seconds(Micros(a).as_seconds()), Micros(a));
            prop_assert!((Micros(a).as_seconds() - a as f64 / 1e6).abs() < 1e-9);
            prop_assert_eq!(Micros::from_seconds((a as f64 + 0.4) / 1e6), Micros(a));
        }
    }
}
