//! Event counts by the luminance of their pixel.

use evpose_core::{EventStream, Plane, SensorSize};

use crate::{EvalError, relative_difference};

/// Luminance over time: frame `i` is at time `i / fps`.
#[derive(Debug, Clone, Copy)]
pub struct Frames<'a> {
    /// Luminance of every pixel.
    pub planes: &'a [Plane<f32>],
    /// Frames per second.
    pub fps: f64,
}

/// Number of classes, with equally many pixels and times each.
const CLASSES: usize = 8;
/// Stride of the sample of luminance values that the edges of classes are taken from.
const SAMPLE_STRIDE: usize = 61;

pub(crate) struct Classes<'a> {
    frames: Frames<'a>,
    edges: Vec<f32>,
}

impl<'a> Classes<'a> {
    pub(crate) fn new(frames: Frames<'a>, sensor: SensorSize) -> Result<Self, EvalError> {
        let fits = |plane: &&Plane<f32>| {
            (plane.width(), plane.height()) == (sensor.width.into(), sensor.height.into())
        };
        if let Some(other) = frames.planes.iter().find(|plane| !fits(plane)) {
            return Err(EvalError::Frames(other.width(), other.height(), sensor));
        }
        let all = frames.planes.iter().flat_map(|plane| plane.data());
        let mut sample: Vec<f32> = all.step_by(SAMPLE_STRIDE).copied().collect();
        sample.sort_by(f32::total_cmp);
        let edge = |class: usize| sample.get(class * sample.len() / CLASSES).copied();
        let edges = (1..CLASSES).filter_map(edge).collect();
        Ok(Self { frames, edges })
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
            counts[self.edges.partition_point(|edge| *edge <= light)] += 1.0;
        }
        counts
    }
}
