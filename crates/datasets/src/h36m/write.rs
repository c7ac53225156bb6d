//! Clips written as they are published.

use std::io::Write;
use std::path::Path;

use evpose_core::{AtomicFile, EventStream, Micros, atomic_write};
use evpose_io::yarp::{CoordinateFormat, YarpSkeleton, write_skeletons};
use evpose_pose::body::{file_from_network, torso};
use glam::Vec2;

use super::{ClipName, SENSOR};
use crate::DatasetError;
use crate::recording::{LabelledRecording, TimedBody};

/// Ticks in a microsecond: one is 80 ns, as in the published logs.
const TICKS_PER_US: f64 = 12.5;
/// How much time a bottle of events holds.
const BOTTLE: Micros = Micros(2_000);

/// Writes `folder/NAME/ch0dvs` and `folder/NAME/chNGT50Hzskeleton`, N being the camera.
///
/// Positions of joints are rounded to whole pixels, as published; a joint that is not known is at
/// (-1, -1). The size of the torso is the length from the left hip to the right shoulder in pixels,
/// -1 where one of the two is not known.
///
/// # Errors
/// If a file cannot be written, events are of another sensor, or before time 0, where logs begin.
pub fn write_published(
    folder: &Path,
    name: &ClipName,
    recording: &LabelledRecording,
) -> Result<(), DatasetError> {
    let LabelledRecording { events, bodies, .. } = recording;
    let clip = folder.join(name.to_string());
    if events.sensor() != SENSOR {
        let reason = format!("{SENSOR} is expected, they are of {}", events.sensor());
        return Err(DatasetError::malformed(clip, "events", reason));
    }
    // Events or bodies may begin first.
    let first = events.t().first().copied().into_iter().chain(bodies.first().map(|b| b.t)).min();
    if let Some(early) = first.filter(|t| t.0 < 0) {
        let reason = format!("one is at {early}, before 0, where a log begins");
        return Err(DatasetError::malformed(clip, "events and bodies", reason));
    }
    let folder = ClipName::events_folder(&clip);
    let path = folder.join("data.log");
    let failed = |source| DatasetError::Io { path: path.clone(), action: "write it", source };
    // The description first: a folder with data is complete.
    let info = "Type: Bottle;\n[0.0] /file/ch0dvs:o [connected]\n";
    atomic_write(folder.join("info.log"), info.as_bytes()).map_err(failed)?;
    let mut file = AtomicFile::create(&path).map_err(failed)?;
    write_events(&mut file, events).map_err(failed)?;
    file.commit().map_err(failed)?;
    let skeletons: Vec<YarpSkeleton> = bodies.iter().map(skeleton).collect();
    let labels = name.labels_channel();
    Ok(write_skeletons(clip.join(&labels), &labels, &skeletons, CoordinateFormat::Whole)?)
}

/// Lines such as `12 0.024000 AE (300000 4721 300012 8825)`: pairs of a tick and a word.
fn write_events(log: &mut impl Write, events: &EventStream) -> std::io::Result<()> {
    let (mut begin, mut bottle) = (0, 0_u64);
    while let Some(&first) = events.t().get(begin) {
        let length = events.t()[begin..].partition_point(|&t| t < first + BOTTLE);
        write!(log, "{bottle} {:.6} AE (", first.as_seconds())?;
        for (index, event) in (begin..begin + length).filter_map(|i| events.get(i)).enumerate() {
            // The clock has 32 bits and runs over.
            let tick = (event.t.0 as f64 * TICKS_PER_US).round() as u64 as u32;
            let is_off = u32::from(!event.polarity.is_on());
            let word = is_off | u32::from(event.x) << 1 | u32::from(event.y) << 12;
            write!(log, "{}{tick} {word}", if index == 0 { "" } else { " " })?;
        }
        writeln!(log, ")")?;
        (begin, bottle) = (begin + length, bottle + 1);
    }
    Ok(())
}

/// As a log has it, on whole pixels.
fn skeleton(body: &TimedBody) -> YarpSkeleton {
    let whole = |v: Vec2| Vec2::new(v.x.round_ties_even(), v.y.round_ties_even());
    let points = body.points_px.map(|point| point.map(whole));
    YarpSkeleton {
        t: body.t,
        // The log has no missing joints: (-1, -1) stands for one.
        joints: file_from_network(&points).map(|point| point.unwrap_or(Vec2::NEG_ONE).to_array()),
        confidences: None,
        head_size_px: None,
        torso_size_px: torso(&points),
    }
}
