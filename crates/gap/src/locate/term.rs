//! Terms of the attribution: groupings of classes by one or two properties.

use super::axis::{Axis, TILES, TIMES};
use super::table::tile;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Term {
    /// One group: measured events are more or fewer everywhere.
    Level,
    Brightness,
    Speed,
    Age,
    Contrast,
    Polarity,
    Direction,
    Place,
    Time,
    Interval,
    Pair(usize, usize),
}

/// Groupings by one property each.
pub(super) const MAIN: [Term; 10] = [
    Term::Level,
    Term::Brightness,
    Term::Speed,
    Term::Age,
    Term::Contrast,
    Term::Polarity,
    Term::Direction,
    Term::Place,
    Term::Time,
    Term::Interval,
];

/// Number of leading terms that depend on the scene alone.
pub(super) const SCENE: usize = MAIN.len() - 1;

impl Term {
    /// Name in verdicts and reports.
    pub(super) fn name(self) -> String {
        let name = match self {
            Self::Level => "overall number",
            Self::Brightness => "brightness",
            Self::Speed => "speed",
            Self::Age => "age",
            Self::Contrast => "contrast",
            Self::Polarity => "polarity",
            Self::Direction => "direction of light",
            Self::Place => "place",
            Self::Time => "time",
            Self::Interval => "interval of pixel",
            Self::Pair(a, b) => return format!("{} x {}", MAIN[a].name(), MAIN[b].name()),
        };
        name.to_owned()
    }

    pub(super) fn count(self) -> usize {
        match self {
            Self::Level => 1,
            Self::Brightness | Self::Contrast | Self::Interval => self.axis().count(),
            Self::Speed => 4,
            Self::Age => 8,
            Self::Polarity | Self::Direction => 2,
            Self::Place => TILES.0 * TILES.1,
            Self::Time => TIMES,
            Self::Pair(a, b) => MAIN[a].count() * MAIN[b].count(),
        }
    }

    fn axis(self) -> Axis {
        match self {
            Self::Contrast => Axis::Contrast,
            Self::Interval => Axis::Interval,
            Self::Speed | Self::Age => Axis::Motion,
            Self::Polarity | Self::Direction => Axis::Sign,
            Self::Time => Axis::Time,
            _ => Axis::Brightness,
        }
    }

    pub(super) fn level(self, key: u64) -> usize {
        let level = self.axis().level(key);
        match self {
            Self::Level => 0,
            // The axis has the fastest first and then rest; groups begin at rest.
            Self::Speed => 3 - level.min(3),
            Self::Age => level.saturating_sub(2),
            Self::Polarity => usize::from(level < 2),
            Self::Direction => usize::from(level == 0 || level == 3),
            Self::Place => tile(key),
            Self::Pair(a, b) => MAIN[a].level(key) * MAIN[b].count() + MAIN[b].level(key),
            _ => level,
        }
    }
}
