//! Movies of the four cameras, as they were recorded.

use std::path::Path;

use evpose_core::{EventStream, Micros};
use evpose_io::aedat2::special_events;
use evpose_io::{Input, OpenOptions, Recording, open_as, source};
use rayon::prelude::*;

use super::{CAMERAS, SENSOR};
use crate::DatasetError;

/// A movie: events on the clock of the cameras, as they were recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct Movie {
    /// Events of each camera. Columns and rows count from the left and the top of its image.
    pub cameras: [EventStream; CAMERAS],
    /// Pulses at the external pin.
    pub pulses: Vec<Micros>,
    /// Remarks, in whole sentences.
    pub remarks: Vec<String>,
}

/// Reads a movie: an AEDAT 2.0 file of the four cameras. With `salvage`, what is readable of a
/// damaged one.
///
/// # Errors
/// If it cannot be read, or is of other cameras.
pub fn read_movie(path: &Path, salvage: bool) -> Result<Movie, DatasetError> {
    let options = |camera| OpenOptions { camera, salvage, ..OpenOptions::default() };
    let header = source(Input::file(path)?, &options(None))?.1.header().clone();
    let is_numbered = header.facts.iter().any(|(name, _)| *name == "camera");
    if header.sensor != Some(SENSOR) || !is_numbered {
        let found = header.sensor.map_or("an unknown sensor".to_owned(), |s| s.to_string());
        let reason = format!("four cameras of {SENSOR} are expected, this is one of {found}");
        return Err(DatasetError::malformed(path, "header", reason));
    }
    // Pulses are not of one camera.
    let pulses = special_events(path, &options(None))?.iter().map(|pulse| pulse.t).collect();
    // A reader gives one camera's events: four read at once.
    let recordings: Result<Vec<Recording>, _> = (0..CAMERAS as u8)
        .into_par_iter()
        .map(|camera| open_as(path, &options(Some(camera))))
        .collect();
    let mut remarks = Vec::new();
    let mut cameras = [(); CAMERAS].map(|()| EventStream::empty(SENSOR));
    for (number, recording) in recordings?.into_iter().enumerate() {
        remarks.extend(remarks_of(number, &recording));
        cameras[number] = recording.stream;
    }
    Ok(Movie { cameras, pulses, remarks })
}

/// Remarks of one camera that the others do not share.
fn remarks_of(number: usize, recording: &Recording) -> Vec<String> {
    let mut remarks = Vec::new();
    if recording.outside > 0 {
        let outside = recording.outside;
        remarks.push(format!("camera {number}: {outside} events are outside the sensor: left out"));
    }
    // Other cameras, pulses and frames are passed over in every movie.
    let others = recording.remarks.iter().filter(|remark| !remark.ends_with("are passed over"));
    remarks.extend(others.map(|remark| format!("camera {number}: {remark}")));
    remarks
}
