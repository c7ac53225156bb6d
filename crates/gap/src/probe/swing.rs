//! Change of log light between two events of a pixel: one threshold, in an ideal sensor.

use crate::probe::{Probe, brightness_third, is_moving, quantile};
use crate::{Block, Entry, Kind, View};

/// Histograms, medians and spreads of the change, in the direction of the event.
#[derive(Debug)]
pub(super) struct Swing;

/// Limits of bins. Common thresholds (0.1, 0.15, 0.2, ...) lie well inside.
const EDGES: [f32; 11] = [-0.4, -0.1, 0.03, 0.07, 0.12, 0.17, 0.23, 0.28, 0.36, 0.47, 0.7];
const BINS: usize = EDGES.len() + 1;
/// After an event of the same polarity, of the other one, and the first of a pixel.
const PASTS: [&str; 3] = ["same", "reversed", "first"];
const GROUPS: usize = 3 * PASTS.len();
/// Share of all events that the edge of a bin may move.
const BIN_TOLERANCE: f64 = 0.002;
/// A hundredth of a common threshold.
const TOLERANCE: f64 = 0.002;

fn bin(swing: f32) -> usize {
    EDGES.iter().filter(|edge| swing >= **edge).count()
}

impl Probe for Swing {
    fn entries(&self) -> Vec<Entry> {
        let group = |i: usize| format!("{} events, brightness third {}", PASTS[i % 3], i / 3);
        let histogram = (0..GROUPS * BINS).map(|i| {
            let name = format!("swing of {}, bin {}", group(i / BINS), i % BINS);
            Entry { block: Block::Swing, name, kind: Kind::Count(BIN_TOLERANCE) }
        });
        let number = |what: &str, i| {
            Entry::number(Block::Swing, format!("{what} of swing, {}", group(i)), TOLERANCE)
        };
        let shapes = (0..GROUPS).flat_map(|i| [number("median", i), number("spread", i)]);
        histogram.chain(shapes).collect()
    }

    fn measure(&self, view: &View<'_>, out: &mut Vec<f64>) {
        let mut histogram = [0.0; GROUPS * BINS];
        let mut swings: [Vec<f32>; GROUPS] = Default::default();
        for event in view.events().iter().filter(|event| is_moving(event.cell)) {
            let past = match event.before() {
                Some((_, was_on)) => usize::from(was_on != event.is_on),
                None => 2,
            };
            let group = 3 * brightness_third(event.cell) + past;
            histogram[group * BINS + bin(event.swing)] += 1.0;
            swings[group].push(event.swing);
        }
        out.extend(histogram);
        for swings in &mut swings {
            out.extend([quantile::median(swings), quantile::spread(swings)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::probe::testing;

    #[test]
    fn the_swing_of_an_ideal_sensor_is_its_threshold() {
        for past in ["same", "first"] {
            let name = format!("median of swing, {past} events, brightness third 1");
            let swing = testing::number(&Swing, testing::events(), &name);
            assert!((swing - 0.2).abs() < 0.002, "{past}: {swing}");
            let name = format!("spread of swing, {past} events, brightness third 1");
            assert!(testing::number(&Swing, testing::events(), &name) < 0.005);
        }
    }

    #[test]
    fn the_swing_without_every_other_event_is_two_thresholds() {
        let mut seen = std::collections::HashMap::new();
        let sparse = testing::changed(|event| {
            let count: &mut u32 = seen.entry((event.x, event.y)).or_default();
            *count += 1;
            count.is_multiple_of(2).then_some(event)
        });
        let name = "median of swing, same events, brightness third 1";
        let swing = testing::number(&Swing, &sparse, name);
        assert!((swing - 0.4).abs() < 0.004, "{swing}");
    }
}
