//! What a camera looked at: luminance over time.

use evpose_core::{Event, Micros, Plane, SensorSize};

use crate::GapError;

/// Luminance planes at equal steps of time, the first at time zero.
#[derive(Debug, Clone)]
pub struct Scene {
    size: SensorSize,
    fps: f64,
    planes: Vec<Plane<f32>>,
    /// Pixels of which nothing is compared; none of them if it is empty.
    blind: Vec<bool>,
}

impl Scene {
    /// A scene of planes that are `1 / fps` seconds apart, linear and relative to white.
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
        if !(fps > 0.0 && fps <= 1e6) {
            return Err(GapError::Scene(format!("{fps} frames per second")));
        }
        let size = SensorSize { width: width as u16, height: height as u16 };
        Ok(Self { size, fps, planes, blind: Vec::new() })
    }

    /// The same scene where some pixels (true, row by row) are not compared: the light that they saw is
    /// not known.
    #[must_use]
    pub fn with_blind(self, blind: Vec<bool>) -> Self {
        Self { blind, ..self }
    }

    /// Pixels that are not compared, row by row; empty if all are.
    pub fn blind(&self) -> &[bool] {
        &self.blind
    }

    /// Whether an event of a pixel is compared.
    pub(crate) fn sees(&self, event: &Event) -> bool {
        let pixel = usize::from(event.y) * usize::from(self.size.width) + usize::from(event.x);
        !self.blind.get(pixel).copied().unwrap_or(false)
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
        &self.planes
    }

    /// When plane `k` is seen.
    pub fn time(&self, k: usize) -> Micros {
        Micros::from_seconds(k as f64 / self.fps)
    }

    /// When the last plane is seen.
    pub fn duration(&self) -> Micros {
        self.time(self.planes.len() - 1)
    }

    /// The first part of the scene, of at least two planes.
    #[must_use]
    pub fn first(&self, duration: Micros) -> Self {
        let last = (duration.as_seconds() * self.fps).round() as usize;
        let planes = self.planes[..(last + 1).clamp(2, self.planes.len())].to_vec();
        Self { planes, blind: self.blind.clone(), ..*self }
    }

    /// The step between two planes.
    pub fn step_s(&self) -> f64 {
        1.0 / self.fps
    }
}
