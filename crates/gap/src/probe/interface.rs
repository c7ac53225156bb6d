//! The interface of probes, and the strata that several of them use.

use crate::{Cell, Entry, View};

/// A pure function from events and scene to summary statistics.
pub trait StatisticProbe: Sync {
    /// Entries of the statistics, the same for all views.
    fn entries(&self) -> Vec<Entry>;

    /// Appends the statistics of a view, one per entry. An undefined statistic is NaN, which counts
    /// as a deviation if the other side has a value.
    fn measure(&self, view: &View<'_>, out: &mut Vec<f64>);
}

/// Dark, middle and bright: two, one and two of the five brightness classes.
pub(super) fn brightness_third(cell: Cell) -> usize {
    [0, 0, 1, 2, 2][cell.brightness()]
}

/// Whether luminance changes, or did less than 5 ms ago.
pub(super) fn is_moving(cell: Cell) -> bool {
    cell.age() <= 1
}
