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
    /// The window of `length` that ends just before `end`.
    pub fn ending_at(end: Micros, length: Micros) -> Self {
        Self { start: end - length, end }
    }

    /// `end - start`.
    pub fn length(self) -> Micros {
        self.end - self.start
    }

    /// Whether `t` lies inside.
    pub fn contains(self, t: Micros) -> bool {
        self.start <= t && t < self.end
    }
}
