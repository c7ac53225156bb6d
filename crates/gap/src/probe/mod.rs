//! What is measured of events, in the same way whoever made them.
//!
//! # A new probe
//! is one file with its entries and its formula, and one line in [`PROBES`].

mod crossing;
mod displacement;
mod fourier;
mod geometry;
mod image;
mod interval;
mod load;
mod quantile;
mod readout;
mod reference;
mod residual;
mod scan;
mod spatial;
mod spectrum;
mod swing;
#[cfg(test)]
pub(crate) mod testing;
mod timing;

pub(crate) use geometry::{TILES, displacements};
pub(crate) use scan::scan_of;

use crate::{Block, Cell, Entry, Kind, View};

/// A pure function of events and scene to numbers.
pub trait Probe: Sync {
    /// What the numbers are, always the same for all views.
    fn entries(&self) -> Vec<Entry>;

    /// Adds the numbers of a view, as many as there are entries. A number that cannot be had is
    /// NaN, at a price.
    fn measure(&self, view: &View<'_>, out: &mut Vec<f64>);
}

/// The first entries of all count every event once.
pub(crate) const ALL_EVENTS: usize = crossing::BY_SPEED;

/// Every probe there is.
pub static PROBES: &[&dyn Probe] = &[
    &crossing::Crossing,
    &interval::Interval,
    &timing::Timing,
    &swing::Swing,
    &spatial::Spatial,
    &spectrum::Spectrum,
    &readout::Readout,
    &load::Load,
    &geometry::Geometry,
];

impl Entry {
    fn count(block: Block, name: impl Into<String>) -> Self {
        Self { block, name: name.into(), kind: Kind::Count(0.0) }
    }

    fn number(block: Block, name: impl Into<String>, tolerance: f64) -> Self {
        Self { block, name: name.into(), kind: Kind::Number(tolerance) }
    }
}

/// Dark, middle and bright: two, one and two of the five classes.
fn brightness_third(cell: Cell) -> usize {
    [0, 0, 1, 2, 2][cell.brightness()]
}

/// Whether light changes, or did less than 5 ms ago.
fn is_moving(cell: Cell) -> bool {
    cell.age() <= 1
}

#[cfg(test)]
mod tests {
    use evpose_core::{EventStream, Micros, TimeWindow};

    use super::*;
    use crate::Layout;
    use crate::probe::testing;

    fn summary(events: &EventStream, window: TimeWindow) -> Vec<f64> {
        Layout::of_all_probes().summarise(&View::new(testing::stage(), events, window))
    }

    #[test]
    fn every_recording_has_a_number_for_every_entry() {
        let entries = Layout::of_all_probes().entries.len();
        let all = testing::events();
        let nothing = EventStream::empty(all.sensor());
        let one = EventStream::from_events(all.sensor(), all.iter().take(1)).unwrap();
        for events in [&nothing, &one, all] {
            for (start, end) in [(0, 600_000), (100_000, 400_000), (200_000, 200_000)] {
                let window = TimeWindow { start: Micros(start), end: Micros(end) };
                assert_eq!(summary(events, window).len(), entries);
            }
        }
    }

    #[test]
    fn a_sensor_of_a_few_pixels_has_them_too() {
        let layout = Layout::of_all_probes();
        for (width, height) in [(1, 1), (5, 2), (3, 9)] {
            let stage = testing::tiny(width, height);
            let events = testing::corner_events(width, height);
            let view = View::new(&stage, &events, testing::whole());
            assert_eq!(layout.summarise(&view).len(), layout.entries.len());
        }
    }

    #[test]
    fn an_ordinary_recording_has_no_number_that_cannot_be_had() {
        let layout = Layout::of_all_probes();
        let numbers = summary(testing::events(), testing::whole());
        for (entry, number) in layout.entries.iter().zip(numbers) {
            assert!(number.is_finite(), "{:?} {}: {number}", entry.block, entry.name);
        }
    }

    #[test]
    fn the_same_events_have_the_same_numbers_to_the_bit() {
        let bits = || -> Vec<u64> {
            summary(testing::events(), testing::whole()).iter().map(|n| n.to_bits()).collect()
        };
        assert_eq!(bits(), bits());
    }

    #[test]
    fn entries_have_names_of_their_own() {
        let layout = Layout::of_all_probes();
        let mut names: Vec<_> = layout.entries.iter().map(|e| (e.block, &e.name)).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), layout.entries.len());
    }
}
