//! Unit and columns of a recording, where its file does not state them.

use std::fmt;
use std::str::FromStr;

use evpose_core::Micros;
use serde::{Deserialize, Serialize};

use crate::names::unit_by_name;

/// Unit of the times in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum TimeUnit {
    /// s
    Seconds,
    /// ms
    Milliseconds,
    /// µs
    Microseconds,
    /// ns
    Nanoseconds,
}

impl TimeUnit {
    /// A whole number of this unit, to the microsecond below; none beyond 64 bits.
    pub(crate) fn whole(self, value: i64) -> Option<Micros> {
        let us = match self {
            Self::Seconds => value.checked_mul(1_000_000),
            Self::Milliseconds => value.checked_mul(1_000),
            Self::Microseconds => Some(value),
            // Times before zero are rounded down, too.
            Self::Nanoseconds => Some(value.div_euclid(1_000)),
        };
        us.map(Micros)
    }

    /// Microseconds that it is long.
    pub(crate) fn microseconds(self) -> f64 {
        match self {
            Self::Seconds => 1e6,
            Self::Milliseconds => 1e3,
            Self::Microseconds => 1.0,
            Self::Nanoseconds => 1e-3,
        }
    }

    /// A number of this unit, to the nearest microsecond; none beyond what a double resolves.
    pub(crate) fn real(self, value: f64) -> Option<Micros> {
        let us = value * self.microseconds();
        (us.abs() < 9e15).then(|| Micros(us.round() as i64))
    }
}

impl fmt::Display for TimeUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Seconds => "s",
            Self::Milliseconds => "ms",
            Self::Microseconds => "us",
            Self::Nanoseconds => "ns",
        })
    }
}

impl FromStr for TimeUnit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        unit_by_name(text).ok_or_else(|| format!("`{text}` is no unit of times: s, ms, us or ns"))
    }
}

/// Names of the columns t, x, y and p in a file that calls them otherwise than usual; their indices from
/// 0 on, where it has no names.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ColumnNames(pub [Option<String>; 4]);

impl ColumnNames {
    /// Indices of columns, if all four are given as such.
    pub(crate) fn indices(&self) -> Option<[usize; 4]> {
        let index = |name: &Option<String>| name.as_ref()?.parse().ok();
        let [t, x, y, p] = &self.0;
        Some([index(t)?, index(x)?, index(y)?, index(p)?])
    }
}

impl fmt::Display for ColumnNames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let stated = ["t", "x", "y", "p"].iter().zip(&self.0);
        let stated = stated.filter_map(|(what, name)| Some(format!("{what}={}", name.as_ref()?)));
        f.write_str(&stated.collect::<Vec<_>>().join(","))
    }
}

impl FromStr for ColumnNames {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut names = Self::default();
        for part in text.split(',') {
            let expected = || format!("`{part}`: expected t=NAME, x=NAME, y=NAME or p=NAME");
            let (what, name) = part.split_once('=').ok_or_else(expected)?;
            let what = ["t", "x", "y", "p"].iter().position(|known| *known == what.trim());
            names.0[what.ok_or_else(expected)?] = Some(name.trim().to_owned());
        }
        Ok(names)
    }
}
