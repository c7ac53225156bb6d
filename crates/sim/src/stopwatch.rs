//! Durations of the parts of a simulation step.

use std::time::{Duration, Instant};

/// Part of a simulation step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SimulationPart {
    /// Motion generation and label.
    Motion,
    /// Skinning: joints, vertices and normals.
    Skinning,
    /// Visibility of every pixel.
    Raster,
    /// Shading of the covered pixels.
    Shading,
    /// Sensor model.
    Sensor,
}

impl SimulationPart {
    /// All parts, in the order of a step.
    pub const ALL: [Self; 5] =
        [Self::Motion, Self::Skinning, Self::Raster, Self::Shading, Self::Sensor];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Motion => "motion",
            Self::Skinning => "skinning",
            Self::Raster => "raster",
            Self::Shading => "shading",
            Self::Sensor => "sensor",
        }
    }
}

/// Accumulated durations of the parts and coverage of the image; disabled by default.
#[derive(Debug, Clone, Default)]
pub struct Stopwatch {
    last: Option<Instant>,
    times: [Duration; SimulationPart::ALL.len()],
    covered: u64,
    sampled_pixels: u64,
}

/// Steps between two samples of the coverage.
const COVERAGE_PERIOD: u64 = 64;

impl Stopwatch {
    pub(crate) fn running() -> Self {
        Self { last: Some(Instant::now()), ..Self::default() }
    }

    pub(crate) fn begin(&mut self) {
        if let Some(last) = &mut self.last {
            *last = Instant::now();
        }
    }

    /// Adds the time since the last call to `part`.
    pub(crate) fn lap(&mut self, part: SimulationPart) {
        if let Some(last) = &mut self.last {
            let now = Instant::now();
            self.times[part as usize] += now - *last;
            *last = now;
        }
    }

    /// Counts the `covered` pixels of every 64th frame of `pixels` pixels.
    pub(crate) fn sample_coverage(
        &mut self,
        frame: u64,
        pixels: usize,
        covered: impl FnOnce() -> usize,
    ) {
        if self.last.is_some() && frame.is_multiple_of(COVERAGE_PERIOD) {
            self.covered += covered() as u64;
            self.sampled_pixels += pixels as u64;
            self.begin();
        }
    }

    /// Accumulated duration of a part.
    pub fn time(&self, part: SimulationPart) -> Duration {
        self.times[part as usize]
    }

    /// Mean share of the image that the hand covered.
    pub fn coverage(&self) -> f64 {
        self.covered as f64 / self.sampled_pixels.max(1) as f64
    }
}
