//! A movement as the four cameras saw it, and as one of them did, with the joints on its image.

use std::path::Path;

use evpose_core::{EventStream, Micros, TimeWindow};

use super::{
    CAMERAS, Dhp19Filters, Dhp19Name, Movie, POSE_INTERVAL, PixelRule, Pose, Projection, Removed,
    SENSOR, Span, movement_span,
};
use crate::DatasetError;
use crate::recording::{LabelledRecording, TimedBody};

/// A movement: events from its beginning to its end.
#[derive(Debug, Clone, PartialEq)]
pub struct Movement {
    /// Events of each camera. Times count from the beginning of the movement.
    pub cameras: [EventStream; CAMERAS],
    /// When it took place, on the clock of the cameras.
    pub span: Span,
    /// Counts of the events that filters removed, if they were applied here.
    pub removed: Option<Removed>,
    /// Remarks, in whole sentences.
    pub remarks: Vec<String>,
}

/// Cuts the movement out of its movie and filters it; `path` is the movie's, for what may be said
/// of it. `poses` is how many there are of the movement.
///
/// # Errors
/// If the pulses of the movie make no sense, or it has no event.
pub fn cut_movement(
    path: &Path,
    movie: &Movie,
    poses: usize,
    filters: &Dhp19Filters,
) -> Result<Movement, DatasetError> {
    let first = movie.cameras.iter().filter_map(|camera| camera.t().first()).min();
    let last = movie.cameras.iter().filter_map(|camera| camera.t().last()).max();
    let Some((&first, &last)) = first.zip(last) else {
        return Err(DatasetError::malformed(path, "events", "there are none"));
    };
    let span = movement_span(&movie.pulses, (first, last), poses)
        .map_err(|fault| DatasetError::malformed(path, "special events", fault.to_string()))?;
    let mut cameras = movie.cameras.each_ref().map(|camera| camera.slice(span.window));
    // Only now, since the limit of hot pixels is a count of events in one movement.
    let removed = Some(filters.apply(&mut cameras));
    // Poses count from the beginning of the movement.
    let cameras = cameras.map(|camera| from_beginning(camera, span.window));
    Ok(Movement { cameras, span, removed, remarks: movie.remarks.clone() })
}

/// The same events, their times counted from the beginning of `window`.
fn from_beginning(camera: EventStream, window: TimeWindow) -> EventStream {
    let (mut t, x, y, polarity) = camera.into_columns();
    t.iter_mut().for_each(|t| *t = *t - window.start);
    EventStream::from_columns(SENSOR, t, x, y, polarity)
        .expect("events of a stream at times that are all moved alike")
}

impl Movement {
    /// Returns the recording of one camera, with the joints on its image: the pose at index `k` is
    /// at `k` times 10 ms.
    ///
    /// # Panics
    /// If there is no such camera.
    pub fn seen_by(
        &self,
        name: Dhp19Name,
        camera: usize,
        projection: &Projection,
        poses: &[Pose],
        rule: PixelRule,
    ) -> LabelledRecording {
        let times = (0..).map(|k| Micros(k * POSE_INTERVAL.0));
        let duration = self.span.window.length();
        // There may be poses after the end of the movement, where no event is.
        let bodies = times.zip(poses).take_while(|(t, _)| *t <= duration);
        let body = |(t, pose)| TimedBody { t, points_px: projection.project_pose(pose, rule) };
        LabelledRecording {
            name: format!("{name}_ch{camera}"),
            events: self.cameras[camera].clone(),
            bodies: bodies.map(body).collect(),
        }
    }
}
