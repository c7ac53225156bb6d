//! The interface of probes, and the strata that several of them use.

use evpose_core::registry_entry;

use crate::{Cell, Entry, View};

/// A pure function from events and scene to summary statistics.
#[derive(Debug)]
pub struct StatisticProbe {
    /// Unique name.
    pub name: &'static str,
    /// Entries of the statistics, the same for all views.
    pub entries: fn() -> Vec<Entry>,
    /// Appends the statistics of a view, one per entry. An undefined statistic is NaN, which counts
    /// as a deviation if the other side has a value.
    pub measure: fn(&View<'_>, &mut Vec<f64>),
}

registry_entry!(StatisticProbe, "probe");

/// Dark, middle and bright: two, one and two of the five brightness classes.
pub(super) fn brightness_third(cell: Cell) -> usize {
    [0, 0, 1, 2, 2][cell.brightness()]
}

/// Whether luminance changes, or did less than 5 ms ago.
pub(super) fn is_moving(cell: Cell) -> bool {
    cell.age() <= 1
}
