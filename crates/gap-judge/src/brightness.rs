//! Events by the luminance that their pixel saw.

use evpose_core::{EventStream, Plane, SensorSize};

use crate::{JudgeError, relative_difference};

/// Luminance over time: frame `i` is seen at `i / fps`.
#[derive(Debug, Clone, Copy)]
pub struct Frames<'a> {
    /// Luminance of every pixel.
    pub planes: &'a [Plane<f32>],
    /// Frames per second.
    pub fps: f64,
}

/// Classes that hold equally many pixels and times.
const CLASSES: usize = 8;
/// Every so manieth value is looked at for the limits of classes.
const SAMPLE: usize = 61;

/// Limits of classes, and the frames to look up.
pub(crate) struct Classes<'a> {
    frames: Frames<'a>,
    limits: Vec<f32>,
}

impl<'a> Classes<'a> {
    pub(crate) fn of(frames: Frames<'a>, sensor: SensorSize) -> Result<Self, JudgeError> {
        let fits = |plane: &&Plane<f32>| {
            (plane.width(), plane.height()) == (sensor.width.into(), sensor.height.into())
        };
        if let Some(other) = frames.planes.iter().find(|plane| !fits(plane)) {
            return Err(JudgeError::Frames(other.width(), other.height(), sensor));
        }
        let all = frames.planes.iter().flat_map(|plane| plane.data());
        let mut sample: Vec<f32> = all.step_by(SAMPLE).copied().collect();
        sample.sort_by(f32::total_cmp);
        let limit = |class: usize| sample.get(class * sample.len() / CLASSES).copied();
        let limits = (1..CLASSES).filter_map(limit).collect();
        Ok(Self { frames, limits })
    }

    pub(crate) fn distance(&self, a: &EventStream, b: &EventStream) -> f64 {
        relative_difference(&self.counts(a), &self.counts(b))
    }

    fn counts(&self, events: &EventStream) -> [f64; CLASSES] {
        let mut counts = [0.0; CLASSES];
        let Some(last) = self.frames.planes.len().checked_sub(1) else { return counts };
        for event in events.iter() {
            let frame = (event.t.as_seconds() * self.frames.fps).max(0.0) as usize;
            let plane = &self.frames.planes[frame.min(last)];
            let light = *plane.at(event.x.into(), event.y.into());
            counts[self.limits.partition_point(|limit| *limit <= light)] += 1.0;
        }
        counts
    }
}
