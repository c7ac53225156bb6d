//! Change of log luminance between two events of a pixel: one threshold, in an ideal sensor.

use crate::probe::interface::{StatisticProbe, brightness_third, is_moving};
use crate::probe::quantile;
use crate::{Entry, StatisticBlock, StatisticKind, View};

/// Histograms, medians and interquartile ranges of the change, in the direction of the event.
pub(super) static PROBE: StatisticProbe =
    StatisticProbe { name: "log_intensity_step", entries, measure };

/// Edges of bins. Common thresholds (0.1, 0.15, 0.2, ...) lie well inside of bins.
const EDGES: [f32; 11] = [-0.4, -0.1, 0.03, 0.07, 0.12, 0.17, 0.23, 0.28, 0.36, 0.47, 0.7];
const BINS: usize = EDGES.len() + 1;
/// Previous event of the pixel: of the same polarity, of the other one, or none.
const PASTS: [&str; 3] = ["same", "reversed", "first"];
const GROUPS: usize = 3 * PASTS.len();
/// Fraction of all events that may fall to either side of the edge of a bin.
const BIN_TOLERANCE: f64 = 0.002;
/// A hundredth of a common threshold.
const TOLERANCE: f64 = 0.002;

fn bin(log_step: f32) -> usize {
    EDGES.iter().filter(|edge| log_step >= **edge).count()
}

fn entries() -> Vec<Entry> {
    let group = |i: usize| format!("{} events, brightness third {}", PASTS[i % 3], i / 3);
    let histogram = (0..GROUPS * BINS).map(|i| {
        let name = format!("log intensity step of {}, bin {}", group(i / BINS), i % BINS);
        Entry {
            block: StatisticBlock::LogIntensityStep,
            name,
            kind: StatisticKind::Count(BIN_TOLERANCE),
        }
    });
    let value = |quantile: &str, i| {
        let name = format!("{quantile} of log intensity step, {}", group(i));
        Entry::value(StatisticBlock::LogIntensityStep, name, TOLERANCE)
    };
    let shapes = (0..GROUPS).flat_map(|i| [value("median", i), value("spread", i)]);
    histogram.chain(shapes).collect()
}

fn measure(view: &View<'_>, out: &mut Vec<f64>) {
    let mut histogram = [0.0; GROUPS * BINS];
    let mut log_steps: [Vec<f32>; GROUPS] = Default::default();
    for event in view.events().iter().filter(|event| is_moving(event.cell)) {
        // By the last event: a refractory pixel or a wrong memory shows in repeated polarities
        // only.
        let past = match event.before() {
            Some((_, was_on)) => usize::from(was_on != event.is_on),
            None => 2,
        };
        let group = 3 * brightness_third(event.cell) + past;
        histogram[group * BINS + bin(event.log_step)] += 1.0;
        log_steps[group].push(event.log_step);
    }
    out.extend(histogram);
    for log_steps in &mut log_steps {
        out.extend([quantile::shrunk_median(log_steps), quantile::shrunk_iqr(log_steps)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::probe::testing;

    #[test]
    fn the_step_of_an_ideal_sensor_is_its_threshold() {
        for past in ["same", "first"] {
            let name = format!("median of log intensity step, {past} events, brightness third 1");
            let log_step = testing::value(&PROBE, testing::events(), &name);
            assert!((log_step - 0.2).abs() < 0.002, "{past}: {log_step}");
            let name = format!("spread of log intensity step, {past} events, brightness third 1");
            assert!(testing::value(&PROBE, testing::events(), &name) < 0.005);
        }
    }

    #[test]
    fn the_step_without_every_other_event_is_two_thresholds() {
        let mut seen = std::collections::HashMap::new();
        let sparse = testing::changed(|event| {
            let count: &mut u32 = seen.entry((event.x, event.y)).or_default();
            *count += 1;
            count.is_multiple_of(2).then_some(event)
        });
        let name = "median of log intensity step, same events, brightness third 1";
        let log_step = testing::value(&PROBE, &sparse, name);
        assert!((log_step - 0.4).abs() < 0.004, "{log_step}");
    }
}
