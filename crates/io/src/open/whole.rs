//! A recording read to its end.
//!
//! A few events with a stamp before that of their predecessor are faults: they are left out and
//! counted. Some programs write whole batches unsorted, though, and one stamp far too late would
//! cost all events behind it: where more than a few are early, all are kept, sorted by time.

use evpose_core::{Event, EventStream, EventStreamBuilder, Micros, Rejected, SensorSize};

use super::{Recording, SensorOrigin};
use crate::{Columns, EventSource, Header, IoError, OpenOptions};

/// Early events that are faults of single stamps, and the share of all from which on they are not.
const FAULTS: usize = 10;
const SHARE: f64 = 1e-3;

/// Reads everything that `source` has left.
pub(super) fn read(
    format: &'static str,
    source: &mut dyn EventSource,
    options: &OpenOptions,
) -> Result<Recording, IoError> {
    // Sources that are in memory hand out their columns.
    let mut columns = source.take_all().unwrap_or_default();
    let mut remarks = Vec::new();
    loop {
        let before = columns.len();
        match source.next(&mut columns) {
            Ok(()) if columns.len() == before => break,
            Ok(()) => {}
            Err(damage) if options.salvage && damage.is_damage() => {
                remarks.push(format!("the rest is lost: {damage}"));
                break;
            }
            Err(other) => return Err(other),
        }
    }
    // Remarks are complete only when everything has been read, but come before the loss.
    remarks.splice(0..0, source.remarks());
    let (sensor, sensor_origin) = sensor_of(source.header(), options, || extent(&columns));
    let Ordered { stream, rejected, sorted } = ordered(sensor, columns);
    Ok(Recording { format, stream, rejected, sorted, sensor_origin, remarks })
}

/// The sensor of a file: as it states, as the caller says, as usual if that holds every event, else
/// the smallest that does.
pub(super) fn sensor_of(
    header: &Header,
    options: &OpenOptions,
    extent: impl FnOnce() -> SensorSize,
) -> (SensorSize, SensorOrigin) {
    match (header.sensor, options.sensor) {
        (Some(stated), _) => (stated, SensorOrigin::Stated),
        (None, Some(given)) => (given, SensorOrigin::Given),
        (None, None) => {
            // A closure: the extent costs a pass over all events, and few formats need it.
            let extent = extent();
            let holds = |s: &SensorSize| extent.width <= s.width && extent.height <= s.height;
            match header.usual_sensor.filter(holds) {
                Some(usual) => (usual, SensorOrigin::Assumed),
                None => (extent, SensorOrigin::Inferred),
            }
        }
    }
}

/// The smallest sensor that holds all events which fit any, of at least one pixel.
pub(super) fn extent(columns: &Columns) -> SensorSize {
    // Without a branch for each: only where some coordinate fits no sensor are events looked at.
    let largest = |values: &[u16]| values.iter().copied().fold(0, u16::max);
    let (mut x, mut y) = (largest(&columns.x), largest(&columns.y));
    if x == u16::MAX || y == u16::MAX {
        let inside = columns.iter().filter(|e| e.x < u16::MAX && e.y < u16::MAX);
        (x, y) = inside.fold((0, 0), |(x, y), event| (x.max(event.x), y.max(event.y)));
    }
    SensorSize { width: x + 1, height: y + 1 }
}

/// Events in order, what could not be used, and how many were not where they belong.
pub(super) struct Ordered {
    pub(super) stream: EventStream,
    pub(super) rejected: Rejected,
    pub(super) sorted: usize,
}

/// How many events are earlier than one before them.
pub(super) fn early(times: &[Micros], latest: &mut Micros) -> usize {
    let mut count = 0;
    for &t in times {
        count += usize::from(t < *latest);
        *latest = t.max(*latest);
    }
    count
}

/// Puts events of a file in order.
pub(super) fn ordered(sensor: SensorSize, columns: Columns) -> Ordered {
    let Columns { t, x, y, polarity } = columns;
    let columns = match EventStream::from_columns(sensor, t, x, y, polarity) {
        Ok(stream) => return Ordered { stream, rejected: Rejected::default(), sorted: 0 },
        Err((t, x, y, polarity)) => Columns { t, x, y, polarity },
    };
    let early = early(&columns.t, &mut Micros(i64::MIN));
    let is_unsorted = early > FAULTS && early as f64 > SHARE * columns.len() as f64;
    let mut events: Vec<Event> = columns.iter().collect();
    drop(columns);
    if is_unsorted {
        // Stable: events of one time keep their order.
        events.sort_by_key(|event| event.t);
    }
    let mut builder = EventStreamBuilder::new(sensor);
    events.into_iter().for_each(|event| builder.push(event));
    let (stream, rejected) = builder.finish();
    Ordered { stream, rejected, sorted: if is_unsorted { early } else { 0 } }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use evpose_core::Polarity;

    use super::*;

    fn events(times: impl IntoIterator<Item = i64>) -> Columns {
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
    fn the_usual_sensor_is_taken_where_it_holds_every_event() {
        let usual = Header { usual_sensor: Some(SensorSize::DAVIS240C), ..Header::default() };
        let of =
            |width| sensor_of(&usual, &OpenOptions::default(), || SensorSize { width, height: 9 });
        assert_eq!(of(240), (SensorSize::DAVIS240C, SensorOrigin::Assumed));
        assert_eq!(of(241), (SensorSize { width: 241, height: 9 }, SensorOrigin::Inferred));
    }

    #[test]
    fn coordinates_that_fit_no_sensor_do_not_make_one() {
        let mut columns = events([0, 1]);
        columns.x[1] = u16::MAX;
        assert_eq!(extent(&columns), SENSOR);
        assert_eq!(extent(&Columns::new()), SENSOR);
    }
}
