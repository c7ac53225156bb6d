//! A recording of any format, in the frame of the sensor that the scene has.

use std::path::Path;

use evpose_core::{Event, EventStream, EventStreamBuilder, Micros, SensorSize};
use evpose_io::{OpenOptions, SensorOrigin};

use crate::GapError;

/// A recording with its provenance and notes.
#[derive(Debug, Clone)]
pub struct LoadedRecording {
    /// The events, in order of time.
    pub events: EventStream,
    /// Count of events outside the sensor, which were left out.
    pub outside: usize,
    /// Unit of the format's time stamps; a microsecond if it has none.
    pub tick: Micros,
    /// Provenance, a line per file.
    pub provenance: Vec<String>,
    /// Notes for the user, a line each.
    pub notes: Vec<String>,
}

/// Reads a recording by `options`. `sensor` is used if neither the file nor the options state one;
/// [`Problems`](super::Problems) compares it with that of the scene.
///
/// # Errors
/// A file that cannot be read or has no events.
pub fn load_recording(
    path: impl AsRef<Path>,
    sensor: Option<SensorSize>,
    options: &OpenOptions,
) -> Result<LoadedRecording, GapError> {
    let path = path.as_ref();
    let mut read = evpose_io::open_as(path, options)?;
    let mut notes = read.remarks.clone();
    if let Some(given) = sensor {
        match read.sensor_origin {
            // The format only assumed its usual size: read again with the scene's.
            SensorOrigin::Assumed => {
                read = evpose_io::open_as(path, &OpenOptions { sensor, ..options.clone() })?;
            }
            SensorOrigin::Inferred => read.stream = placed(&read.stream, given, &mut notes),
            SensorOrigin::Stated | SensorOrigin::Given => {}
        }
    }
    let is_framed = read.format == "evc";
    // Stamps are known to a frame.
    let tick = if is_framed { evpose_io::evc::FRAME } else { Micros(1) };
    if is_framed {
        // Events of one frame have no order in time: sort them by pixel, as simulated ones are.
        read.stream = by_pixel(&read.stream);
    }
    let (events, outside) = (read.stream, read.outside);
    if events.is_empty() {
        return Err(GapError::Recording(format!(
            "{}: no events ({outside} outside the sensor)",
            path.display()
        )));
    }
    let span = [0, events.len() - 1].map(|i| events.t()[i].as_seconds());
    let provenance = vec![format!(
        "{}: {} events of a sensor of {} from {:.6} s to {:.6} s ({})",
        path.display(),
        events.len(),
        events.sensor(),
        span[0],
        span[1],
        read.format
    )];
    Ok(LoadedRecording { events, outside, tick, provenance, notes })
}

/// Sorts events of equal time by pixel, row by row from the top.
fn by_pixel(events: &EventStream) -> EventStream {
    let mut all: Vec<Event> = events.iter().collect();
    all.sort_by_key(|event| (event.t, event.y, event.x));
    on(events.sensor(), all)
}

/// Puts events of a file without a sensor size on the given sensor, or on the transposed one.
fn placed(events: &EventStream, given: SensorSize, notes: &mut Vec<String>) -> EventStream {
    let smallest = events.sensor();
    let turned = SensorSize { width: given.height, height: given.width };
    let holds = |size: SensorSize| smallest.width <= size.width && smallest.height <= size.height;
    let (size, how) = match (holds(given), holds(turned)) {
        (true, _) => (given, "as the scene has it"),
        (false, true) => (turned, "the scene's with width and height swapped"),
        (false, false) => (smallest, "the smallest that holds every event"),
    };
    notes.push(format!("the recording does not state its sensor: {size} is taken, {how}"));
    on(size, events.iter())
}

/// Puts events, in order of time, on a sensor that contains all of them.
pub(super) fn on(size: SensorSize, events: impl IntoIterator<Item = Event>) -> EventStream {
    let mut builder = EventStreamBuilder::new(size);
    events.into_iter().for_each(|event| builder.push(event));
    builder.finish().0
}
