//! The ways to sort classes that are asked how much of a disagreement they explain.

use super::axis::{Axis, TILES, TIMES};
use super::table::tile;

/// A way to sort classes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Term {
    /// All are one: measured events are more or fewer everywhere.
    Level,
    Brightness,
    Speed,
    Age,
    Contrast,
    Polarity,
    Direction,
    Place,
    Time,
    Pause,
    Pair(usize, usize),
}

/// Those of one property each.
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
    Term::Pause,
];

/// How many of these the scene alone decides.
pub(super) const SCENE: usize = MAIN.len() - 1;

impl Term {
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
            Self::Pause => "pause of pixel",
            Self::Pair(a, b) => return format!("{} x {}", MAIN[a].name(), MAIN[b].name()),
        };
        name.to_owned()
    }

    pub(super) fn count(self) -> usize {
        match self {
            Self::Level => 1,
            Self::Brightness | Self::Contrast | Self::Pause => self.axis().count(),
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
            Self::Pause => Axis::Pause,
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
