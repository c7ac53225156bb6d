//! Stretches of a recording whose labels are dense enough to be interpolated.

use std::ops::Range;

use evpose_core::{EventStream, Micros, TimeWindow};

use crate::import::ImportError;
use crate::runs::runs;
use std::path::Path;

/// Length of a frame of `.evc` files, to which recordings are cut.
pub(crate) const MS: Micros = Micros(1_000);
/// Time without events at either end of a recording that may have labels.
const REST: Micros = Micros(1_000_000);

/// Indices of labels without a gap longer than `max_gap` among them.
pub(crate) fn stretches(times: &[Micros], max_gap: Micros) -> Vec<Range<usize>> {
    runs(times, |before, now| *now - *before <= max_gap)
}

/// The range of `times`, in order, that lie within a recording; `path` is the label file.
///
/// # Errors
/// If there is none, or the recording is empty.
pub(crate) fn within(
    times: &[Micros],
    events: &EventStream,
    path: &Path,
) -> Result<Range<usize>, ImportError> {
    let (Some(&first), Some(&last)) = (events.t().first(), events.t().last()) else {
        return Err(ImportError::Empty { path: path.to_owned(), content: "events beside it" });
    };
    let (Some(&start), Some(&end)) = (times.first(), times.last()) else {
        return Err(ImportError::Empty { path: path.to_owned(), content: "labels" });
    };
    // A scene at rest makes no events: labels may begin before the first and end after the last.
    let window = TimeWindow { start: floor_ms(first) - REST, end: floor_ms(last) + REST };
    // Times are in order: two searches are enough.
    let range =
        times.partition_point(|t| *t < window.start)..times.partition_point(|t| *t < window.end);
    if range.is_empty() {
        return Err(ImportError::Apart {
            path: path.to_owned(),
            labels: [start, end],
            events: [first, last],
        });
    }
    Ok(range)
}

/// The time stamp at which a recording begins: 0 if its first event is soon after, as in a clock
/// that started with it.
pub(crate) fn begin_of(events: &EventStream) -> Micros {
    let first = events.t().first().copied().unwrap_or_default();
    if (Micros(0)..REST).contains(&first) { Micros(0) } else { first }
}

/// A sequence that was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenSequence {
    /// Name of its files without ending.
    pub name: String,
    /// Its start in the clock of the recording.
    pub start: Micros,
    /// Count of its labels.
    pub labels: usize,
}

/// The start of the millisecond of a time stamp.
pub(crate) fn floor_ms(t: Micros) -> Micros {
    Micros(t.0.div_euclid(MS.0) * MS.0)
}

/// The events of a window with time stamps that count from its start.
pub(crate) fn cut(events: &EventStream, window: TimeWindow) -> EventStream {
    let mut taken = EventStream::empty(events.sensor());
    for mut event in events.slice(window).iter() {
        event.t = event.t - window.start;
        // In order and on the sensor, as before.
        let _ = taken.push(event);
    }
    taken
}

/// Name of the sequence of stretch `index` of `count`: that of the recording if there is but one.
pub(crate) fn name_of(recording: &str, index: usize, count: usize) -> String {
    if count == 1 { recording.to_owned() } else { format!("{recording}-{index:03}") }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Polarity, SensorSize};

    use super::*;

    fn micros(times: &[i64]) -> Vec<Micros> {
        times.iter().map(|t| Micros(*t)).collect()
    }

    fn events(times: &[i64]) -> EventStream {
        let event = |t: &i64| Event { t: Micros(*t), x: 0, y: 0, polarity: Polarity::On };
        EventStream::from_events(SensorSize::DAVIS240C, times.iter().map(event)).unwrap()
    }

    #[test]
    fn labels_are_separated_at_long_gaps() {
        let times = micros(&[0, 10, 20, 90, 95, 300]);
        assert_eq!(stretches(&times, Micros(50)), [0..3, 3..5, 5..6]);
        assert!(stretches(&[], Micros(50)).is_empty());
        assert_eq!(name_of("walk", 0, 1), "walk");
        assert_eq!(name_of("walk", 1, 3), "walk-001");
    }

    #[test]
    fn labels_outside_of_the_recording_are_dropped_and_both_spans_reported() {
        let path = Path::new("l.csv");
        let recording = events(&[5_300, 9_999]);
        assert_eq!(
            within(&micros(&[-995_001, -995_000, 9_000, 1_009_000]), &recording, path).unwrap(),
            1..3
        );
        let message =
            within(&micros(&[-9_000_000, -8_000_000]), &recording, path).unwrap_err().to_string();
        assert!(message.contains("0.0053 s to 0.009999 s"), "{message}");
    }

    #[test]
    fn events_count_from_the_start_of_their_window() {
        let taken = cut(
            &events(&[1, 5_300, 9_999]),
            TimeWindow { start: Micros(5_000), end: Micros(9_999) },
        );
        assert_eq!(taken.t(), [Micros(300)]);
        assert_eq!(floor_ms(Micros(-1)), Micros(-1_000));
    }
}
