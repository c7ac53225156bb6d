//! Events put into the order of time.
//!
//! A few events with a stamp before that of their predecessor are faults: they are left out and
//! counted. Some programs write whole batches unsorted, though, and one stamp far too late would
//! cost all events behind it: where more than a few are early, all are kept, sorted by time.

use evpose_core::{Event, EventStream, EventStreamBuilder, Rejected, SensorSize};

/// Early events that are faults of single stamps, and the share of all from which on they are not.
const FAULTS: usize = 10;
const SHARE: f64 = 1e-3;

/// Share of steps in which times do not go back.
const TIMELY: f64 = 0.9;

/// Events in order, what could not be used, and how many were not where they belong.
pub(crate) struct Ordered {
    pub(crate) stream: EventStream,
    pub(crate) rejected: Rejected,
    pub(crate) sorted: usize,
}

/// Puts events of a file in order.
pub(crate) fn ordered(sensor: SensorSize, mut events: Vec<Event>) -> Ordered {
    let mut last = i64::MIN;
    let mut early = 0;
    for event in &events {
        early += usize::from(event.t.0 < last);
        last = last.max(event.t.0);
    }
    let is_unsorted = early > FAULTS && early as f64 > SHARE * events.len() as f64;
    if is_unsorted {
        // Stable: events of one time keep their order.
        events.sort_by_key(|event| event.t);
    }
    let mut builder = EventStreamBuilder::new(sensor);
    events.into_iter().for_each(|event| builder.push(event));
    let (stream, rejected) = builder.finish();
    Ordered { stream, rejected, sorted: if is_unsorted { early } else { 0 } }
}

/// Whether a column of numbers may be that of times: over a twentieth of its length, numbers of any
/// other column fall as often as they rise.
pub(crate) fn is_time(values: &(impl ExactSizeIterator<Item = f64> + Clone)) -> bool {
    let lag = (values.len() / 20).max(1);
    let pairs = values.clone().zip(values.clone().skip(lag));
    let steps = values.len().saturating_sub(lag);
    let forward = pairs.filter(|(a, b)| b >= a).count();
    forward as f64 >= TIMELY * steps as f64
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use evpose_core::{Micros, Polarity};

    use super::*;

    fn events(times: impl IntoIterator<Item = i64>) -> Vec<Event> {
        let event = |t| Event { t: Micros(t), x: 0, y: 0, polarity: Polarity::On };
        times.into_iter().map(event).collect()
    }

    const SENSOR: SensorSize = SensorSize { width: 1, height: 1 };

    #[test]
    fn a_few_early_events_are_left_out() {
        let found = ordered(SENSOR, events((0..1000).map(|t| if t == 500 { 3 } else { t })));
        assert_eq!((found.stream.len(), found.rejected.out_of_order, found.sorted), (999, 1, 0));
    }

    #[test]
    fn batches_without_order_are_sorted_and_nothing_is_lost() {
        let found = ordered(SENSOR, events((0..1000).map(|t| t / 10 * 10 + (7 * t) % 10)));
        assert_eq!((found.stream.len(), found.rejected.total()), (1000, 0));
        assert!(found.sorted > 300, "{}", found.sorted);
        assert!(found.stream.t().is_sorted());
    }

    #[test]
    fn one_stamp_that_is_far_too_late_does_not_cost_the_rest() {
        let found = ordered(SENSOR, events(std::iter::once(9_000_000).chain(0..1000)));
        assert_eq!((found.stream.len(), found.sorted), (1001, 1000));
    }

    #[test]
    fn times_are_told_from_columns_and_polarities() {
        let is_time = |value: fn(usize) -> usize| {
            let values: Vec<f64> = (0..1000).map(|k| value(k) as f64).collect();
            is_time(&values.iter().copied())
        };
        assert!(is_time(|k| 3 * k) && is_time(|k| k / 10 * 10 + (7 * k) % 10));
        assert!(!is_time(|k| (37 * k) % 101) && !is_time(|k| (k / 3) % 2));
    }
}
