//! Clips as they are published: folders of YARP logs.

use std::path::Path;

use evpose_io::yarp::{YarpSkeleton, read_skeletons};
use evpose_io::{OpenOptions, open_as};

use super::{ClipName, SENSOR};
use crate::DatasetError;
use crate::recording::{LabelledRecording, TimedBody};

/// A published clip, and what else there is to be known of its events.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// Events and joints.
    pub recording: LabelledRecording,
    /// In whole sentences without a full stop.
    pub remarks: Vec<String>,
}

/// Reads the clip called `name` in `folder`. The length of a tick of its clock, in microseconds, is
/// measured by the log, unless it is given.
///
/// # Errors
/// If its logs cannot be read.
pub fn read_published(
    folder: &Path,
    name: &ClipName,
    tick_us: Option<f64>,
) -> Result<Clip, DatasetError> {
    let clip = folder.join(name.to_string());
    let sensor = Some(SENSOR);
    let options = OpenOptions { sensor, tick_us, ..OpenOptions::default() };
    let events = open_as(ClipName::events_folder(&clip), &options)?;
    let skeletons = read_skeletons(clip.join(name.labels_channel()))?;
    let mut remarks = events.remarks;
    if events.outside > 0 {
        remarks.push(format!("{} events are outside {SENSOR} and left out", events.outside));
    }
    let body =
        |skeleton: &YarpSkeleton| TimedBody { t: skeleton.t, points_px: skeleton.points_px() };
    let bodies = skeletons.iter().map(body).collect();
    let recording = LabelledRecording { name: name.to_string(), events: events.stream, bodies };
    Ok(Clip { recording, remarks })
}
