//! Probes: summary statistics of events, computed in the same way from measured and simulated ones.
//!
//! # A new probe
//! is one file with its entries and its formula, and one line in [`PROBES`].

use evpose_core::Registry;

mod crossing;
mod displacement;
mod geometry;
mod image;
mod interface;
mod interval;
mod load;
mod log_intensity_step;
mod quantile;
mod readout;
mod reference;
mod residual;
mod scan;
mod spatial;
mod spectrum;
#[cfg(test)]
pub(crate) mod testing;
mod timing;

pub(crate) use geometry::{TILES, displacements};
pub(crate) use scan::scan_of;

pub use interface::StatisticProbe;

/// Bins of the longest spectrum.
const MAX_BINS: usize = 1 << 15;

/// Number of leading entries that together count every event once.
pub(crate) const ALL_EVENTS: usize = crossing::BY_SPEED;

/// All probes, in the order of their entries in a summary; those of other crates come last.
pub static PROBES: Registry<StatisticProbe> = Registry::new(&[
    &crossing::PROBE,
    &interval::PROBE,
    &timing::PROBE,
    &log_intensity_step::PROBE,
    &spatial::PROBE,
    &spectrum::PROBE,
    &readout::PROBE,
    &load::PROBE,
    &geometry::PROBE,
]);

#[cfg(test)]
mod tests {
    use evpose_core::{EventStream, Micros, TimeWindow};

    use super::PROBES;
    use crate::probe::testing;
    use crate::{Layout, View};

    fn summary(events: &EventStream, window: TimeWindow) -> Vec<f64> {
        Layout::of_all_probes().summarise(&View::new(testing::reference_scene(), events, window))
    }

    #[test]
    fn every_recording_has_a_value_for_every_entry() {
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
            let reference_scene = testing::tiny(width, height);
            let events = testing::corner_events(width, height);
            let view = View::new(&reference_scene, &events, testing::whole());
            assert_eq!(layout.summarise(&view).len(), layout.entries.len());
        }
    }

    #[test]
    fn an_ordinary_recording_has_no_undefined_value() {
        let layout = Layout::of_all_probes();
        let values = summary(testing::events(), testing::whole());
        for (entry, value) in layout.entries.iter().zip(values) {
            assert!(value.is_finite(), "{:?} {}: {value}", entry.block, entry.name);
        }
    }

    #[test]
    fn the_same_events_have_the_same_values_to_the_bit() {
        let bits = || -> Vec<u64> {
            summary(testing::events(), testing::whole()).iter().map(|n| n.to_bits()).collect()
        };
        assert_eq!(bits(), bits());
    }

    #[test]
    fn probes_and_entries_have_names_of_their_own() {
        let mut probes = PROBES.names();
        probes.sort_unstable();
        probes.dedup();
        assert_eq!(probes.len(), PROBES.len());
        let layout = Layout::of_all_probes();
        let mut names: Vec<_> = layout.entries.iter().map(|e| (e.block, &e.name)).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), layout.entries.len());
    }
}
