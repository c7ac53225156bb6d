//! A recording read to its end.

use std::path::Path;

use evpose_core::{EventStream, EventStreamBuilder, SensorSize};

use super::extent::{Extent, believed};
use super::outside::OutsideCount;
use super::{Recording, SensorOrigin};
use crate::{Columns, EventSource, Header, IoError, OpenOptions};

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
    match source.read_rest(&mut columns) {
        Err(damage) if options.salvage && damage.is_damage() => {
            remarks.push(format!("the rest is lost: {damage}"));
        }
        read => read?,
    }
    // Remarks are complete only when everything has been read, but come before the loss.
    remarks.splice(0..0, source.remarks());
    let (sensor, sensor_origin) =
        sensor_of(path, source.header(), options, || Extent::of(&columns).size())?;
    let (stream, outside) = stream_of(sensor, columns);
    outside.check(path, sensor, true)?;
    Ok(Recording { format, stream, outside: outside.outside(), sensor_origin, remarks })
}

/// Hands every batch that `source` has left to `take`, without keeping it; returns the damage behind
/// them where that is salvaged.
pub(super) fn read_past(
    source: &mut dyn EventSource,
    options: &OpenOptions,
    mut take: impl FnMut(&Columns),
) -> Result<Option<IoError>, IoError> {
    let mut columns = Columns::new();
    loop {
        columns.clear();
        let read = source.next(&mut columns);
        // What stands before a fault counts.
        take(&columns);
        match read {
            Ok(()) if columns.is_empty() => return Ok(None),
            Ok(()) => {}
            Err(damage) if options.salvage && damage.is_damage() => return Ok(Some(damage)),
            Err(other) => return Err(other),
        }
    }
}

/// The sensor of a file: as it states, as the caller says, as usual if that holds every event, else
/// the smallest that does.
///
/// # Errors
/// If it is larger than any sensor.
pub(super) fn sensor_of(
    path: &Path,
    header: &Header,
    options: &OpenOptions,
    extent: impl FnOnce() -> SensorSize,
) -> Result<(SensorSize, SensorOrigin), IoError> {
    let (sensor, origin) = match (header.sensor, options.sensor) {
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
    };
    Ok((believed(path, sensor)?, origin))
}

/// The events on the sensor, and the count of the others.
fn stream_of(sensor: SensorSize, columns: Columns) -> (EventStream, OutsideCount) {
    let mut outside = OutsideCount::default();
    let Columns { t, x, y, polarity } = columns;
    // Nearly always all events fit, and then the columns become the stream without a copy.
    let columns = match EventStream::from_columns(sensor, t, x, y, polarity) {
        Ok(stream) => return (stream, outside),
        Err((t, x, y, polarity)) => Columns { t, x, y, polarity },
    };
    let mut builder = EventStreamBuilder::new(sensor);
    columns.iter().for_each(|event| builder.push(event));
    outside.add(&columns, 0, sensor);
    (builder.finish().0, outside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_sensor_is_taken_where_it_holds_every_event() {
        let usual = Header { usual_sensor: Some(SensorSize::DAVIS240C), ..Header::default() };
        let of = |width| {
            let extent = || SensorSize { width, height: 9 };
            sensor_of(Path::new("events"), &usual, &OpenOptions::default(), extent).unwrap()
        };
        assert_eq!(of(240), (SensorSize::DAVIS240C, SensorOrigin::Assumed));
        assert_eq!(of(241), (SensorSize { width: 241, height: 9 }, SensorOrigin::Inferred));
    }
}
