//! Luminance over time in front of the camera.

use std::sync::Arc;

use evpose_core::{Event, Micros, Plane, SensorSize};

use crate::GapError;
use crate::light_behind_optics::LightBehindOptics;

/// Luminance planes at equal time steps, the first at time zero.
#[derive(Debug, Clone)]
pub struct LightSequence {
    size: SensorSize,
    fps: f64,
    /// Shared with the parts of the scene.
    all: Arc<Vec<Plane<f32>>>,
    /// Number of planes of this part, from the first.
    count: usize,
    /// Pixels (true, row by row) that are excluded from the comparison; empty if there are none.
    masked: Vec<bool>,
    /// Shared with the parts of the scene as well.
    pub(crate) behind: Arc<LightBehindOptics>,
}

impl LightSequence {
    /// A scene of planes `1 / fps` seconds apart, of linear luminance relative to white.
    ///
    /// # Errors
    /// Fewer than two planes, planes of different sizes, or a rate that is not positive.
    pub fn new(fps: f64, planes: Vec<Plane<f32>>) -> Result<Self, GapError> {
        let [first, _, ..] = planes.as_slice() else {
            return Err(GapError::Scene(format!(
                "{} frames: at least two are needed",
                planes.len()
            )));
        };
        let (width, height) = (first.width(), first.height());
        if planes.iter().any(|plane| (plane.width(), plane.height()) != (width, height)) {
            return Err(GapError::Scene("frames are not all of one size".to_owned()));
        }
        // Times are whole microseconds.
        if !(fps > 0.0 && fps <= 1e6) {
            return Err(GapError::Scene(format!("{fps} frames per second")));
        }
        let size = SensorSize { width: width as u16, height: height as u16 };
        let (count, all) = (planes.len(), Arc::new(planes));
        Ok(Self { size, fps, all, count, masked: Vec::new(), behind: Arc::default() })
    }

    /// The same scene with some pixels (true, row by row) excluded from the comparison, because
    /// their light is not known.
    #[must_use]
    pub fn with_mask(self, masked: Vec<bool>) -> Self {
        Self { masked, ..self }
    }

    /// Pixels that are excluded from the comparison (true, row by row); empty if there are none.
    pub fn masked(&self) -> &[bool] {
        &self.masked
    }

    pub(crate) fn is_compared(&self, event: &Event) -> bool {
        let pixel = usize::from(event.y) * usize::from(self.size.width) + usize::from(event.x);
        !self.masked.get(pixel).copied().unwrap_or(false)
    }

    /// Width and height in pixels.
    pub fn size(&self) -> SensorSize {
        self.size
    }

    /// Planes per second.
    pub fn fps(&self) -> f64 {
        self.fps
    }

    /// The luminance planes.
    pub fn planes(&self) -> &[Plane<f32>] {
        &self.all[..self.count]
    }

    /// Time of plane `k`.
    pub fn time(&self, k: usize) -> Micros {
        Micros::from_seconds(k as f64 / self.fps)
    }

    /// Time of the last plane.
    pub fn duration(&self) -> Micros {
        self.time(self.count - 1)
    }

    /// The first `duration` of the scene, at least two planes.
    #[must_use]
    pub fn first(&self, duration: Micros) -> Self {
        let last = (duration.as_seconds() * self.fps).round() as usize;
        let count = (last + 1).clamp(2, self.count);
        Self {
            count,
            all: Arc::clone(&self.all),
            masked: self.masked.clone(),
            behind: Arc::clone(&self.behind),
            ..*self
        }
    }

    /// Time between two planes, seconds.
    pub fn step_s(&self) -> f64 {
        1.0 / self.fps
    }
}
