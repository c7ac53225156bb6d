//! A recording read to its end.

use std::path::Path;

use evpose_core::{EventStream, EventStreamBuilder, SensorSize};

use super::{Recording, SensorOrigin};
use crate::{Columns, EventSource, Header, IoError, OpenOptions};

/// Events outside the sensor up to which it is not in doubt.
const FEW: usize = 10;

/// Reads everything that `source` has left.
pub(super) fn read(
    path: &Path,
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
    let events = columns.len();
    let (stream, outside) = stream_of(sensor, columns);
    if is_elsewhere(outside, events) {
        return Err(IoError::Outside { path: path.to_owned(), sensor, outside, events });
    }
    Ok(Recording { format, stream, outside, sensor_origin, remarks })
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

/// The events on the sensor, and the count of the others.
fn stream_of(sensor: SensorSize, columns: Columns) -> (EventStream, usize) {
    let Columns { t, x, y, polarity } = columns;
    let columns = match EventStream::from_columns(sensor, t, x, y, polarity) {
        Ok(stream) => return (stream, 0),
        Err((t, x, y, polarity)) => Columns { t, x, y, polarity },
    };
    let mut builder = EventStreamBuilder::new(sensor);
    columns.iter().for_each(|event| builder.push(event));
    let (stream, rejected) = builder.finish();
    (stream, rejected.total())
}

/// Whether so many events are outside the sensor that it is another one: more than a tenth.
pub(super) fn is_elsewhere(outside: usize, events: usize) -> bool {
    outside > FEW && outside * 10 > events
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use evpose_core::{Event, Micros, Polarity};

    use super::*;

    fn events(times: impl IntoIterator<Item = i64>) -> Columns {
        let event = |t| Event { t: Micros(t), x: 0, y: 0, polarity: Polarity::On };
        times.into_iter().map(event).collect()
    }

    const SENSOR: SensorSize = SensorSize { width: 1, height: 1 };

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
