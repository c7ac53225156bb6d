//! `.evc` in the registry of formats.

use std::path::Path;

use evpose_core::{EventStream, Micros, Rejected, SensorSize};

use super::{EvcReader, EvcWindow, EvcWriter, FRAME, NEW_FRAME, RECORD};
use crate::info::Labels;
use crate::{Format, Info, IoError, MetaReader, Recording, SensorOrigin};

/// The registry's entry.
pub(crate) const FORMAT: Format = Format {
    name: "evc",
    summary: "EventHands sequence: frames of 1 ms, labels in a .meta file beside it",
    endings: &[".evc"],
    // A marker begins the file; of text, no byte is 255.
    probe: |head| head.first_chunk::<RECORD>().is_some_and(|record| record[3] == NEW_FRAME),
    read,
    write,
    info,
};

fn read(path: &Path, sensor: Option<SensorSize>) -> Result<Recording, IoError> {
    let (reader, sensor_origin) = match sensor {
        Some(sensor) => (EvcReader::open_with(path, sensor)?, SensorOrigin::Given),
        None => (EvcReader::open(path)?, SensorOrigin::Assumed),
    };
    let stream = reader.read_stream(0..reader.frames())?;
    Ok(Recording {
        format: FORMAT.name,
        stream,
        rejected: Rejected::default(),
        sorted: 0,
        sensor_origin,
    })
}

/// Frames count from time 0.
fn write(path: &Path, events: &EventStream) -> Result<(), IoError> {
    let mut writer = EvcWriter::create(path, events.sensor())?;
    writer.stream(events, Micros(0))?;
    writer.finish()
}

fn info(path: &Path, sensor: Option<SensorSize>) -> Result<Info, IoError> {
    let (reader, sensor_origin) = match sensor {
        Some(sensor) => (EvcReader::open_with(path, sensor)?, SensorOrigin::Given),
        None => open_assuming(path)?,
    };
    let (extent, sensor) = (reader.extent(), reader.sensor());
    let mut warnings = Vec::new();
    match sensor_origin {
        SensorOrigin::Inferred => warnings.push(format!(
            "events lie outside {}: the sensor is taken to be the smallest that holds them",
            SensorSize::DAVIS240C
        )),
        SensorOrigin::Assumed if 2 * extent.width <= sensor.width => warnings.push(format!(
            "events fill no more than {extent}: the sensor may be smaller than assumed"
        )),
        _ => {}
    }
    let labels = labels_beside(path, reader.frames(), &mut warnings);
    Ok(Info {
        path: path.to_owned(),
        format: FORMAT.name,
        sensor,
        sensor_origin,
        duration: reader.duration(),
        events: reader.events(),
        on_events: reader.on_events(),
        span: span(&reader)?,
        labels,
        warnings,
    })
}

/// The published sensor, or the smallest that holds every event where that one is too small.
fn open_assuming(path: &Path) -> Result<(EvcReader, SensorOrigin), IoError> {
    let reader = EvcReader::open_inferring_sensor(path)?;
    let published = SensorSize::DAVIS240C;
    let extent = reader.extent();
    if extent.width <= published.width && extent.height <= published.height {
        return Ok((reader.with_sensor(published), SensorOrigin::Assumed));
    }
    Ok((reader, SensorOrigin::Inferred))
}

fn labels_beside(path: &Path, frames: u64, warnings: &mut Vec<String>) -> Option<Labels> {
    let path = path.with_extension("meta");
    if !path.is_file() {
        return None;
    }
    let opened = MetaReader::open_prefix(&path);
    let (labels, fault) = match opened {
        Ok((labels, fault)) => (labels, fault),
        Err(fault) => {
            warnings.push(format!("labels: {fault}"));
            return None;
        }
    };
    warnings.extend(fault.map(|fault| format!("labels: {fault}")));
    let (records, values) = (labels.records(), labels.values());
    if records != frames {
        warnings.push(format!("{records} labels for {frames} frames: one of the files is cut"));
    }
    Some(Labels { path, records, values })
}

/// Times of the first and the last frame that have events.
fn span(reader: &EvcReader) -> Result<Option<(Micros, Micros)>, IoError> {
    const STEP: u64 = 1024;
    let mut window = EvcWindow::new();
    let time = |start: u64, frame: u32| Micros((start + u64::from(frame)) as i64 * FRAME.0);
    let mut first = None;
    let mut start = 0;
    while first.is_none() && start < reader.frames() {
        let end = reader.frames().min(start + STEP);
        reader.read_frames(start..end, &mut window)?;
        first = window.events().next().map(|event| time(start, event.frame));
        start = end;
    }
    let Some(first) = first else { return Ok(None) };
    let mut end = reader.frames();
    while end > 0 {
        let start = end.saturating_sub(STEP);
        reader.read_frames(start..end, &mut window)?;
        if let Some(event) = window.events().last() {
            return Ok(Some((first, time(start, event.frame))));
        }
        end = start;
    }
    Ok(None)
}
