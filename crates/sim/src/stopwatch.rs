//! Where the time of a simulation goes.

use std::time::{Duration, Instant};

/// A part of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Where the hand is to be, and its label.
    Motion,
    /// Joints, vertices and normals.
    Skinning,
    /// Which surface every pixel sees.
    Raster,
    /// The light of every pixel of the hand.
    Shading,
    /// Events.
    Sensor,
}

impl Part {
    /// Every part, in the order of a step.
    pub const ALL: [Self; 5] =
        [Self::Motion, Self::Skinning, Self::Raster, Self::Shading, Self::Sensor];

    /// One word.
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

/// Time spent in every part of a sequence's steps, and what was seen. It stands still until it is
/// asked for.
#[derive(Debug, Clone, Default)]
pub struct Stopwatch {
    last: Option<Instant>,
    times: [Duration; Part::ALL.len()],
    covered: u64,
    looked: u64,
}

/// Steps between two looks at how much of the image the hand covers.
const LOOK_EVERY: u64 = 64;

impl Stopwatch {
    /// A stopwatch that runs.
    pub(crate) fn running() -> Self {
        Self { last: Some(Instant::now()), ..Self::default() }
    }

    /// Begins a step.
    pub(crate) fn begin(&mut self) {
        if let Some(last) = &mut self.last {
            *last = Instant::now();
        }
    }

    /// Everything since the last call was `part`.
    pub(crate) fn lap(&mut self, part: Part) {
        if let Some(last) = &mut self.last {
            let now = Instant::now();
            self.times[part as usize] += now - *last;
            *last = now;
        }
    }

    /// Looks at the covered pixels of some frames; their share of an image of `pixels` follows.
    pub(crate) fn look(&mut self, frame: u64, pixels: usize, covered: impl FnOnce() -> usize) {
        if self.last.is_some() && frame.is_multiple_of(LOOK_EVERY) {
            self.covered += covered() as u64;
            self.looked += pixels as u64;
            self.begin();
        }
    }

    /// Time spent in a part.
    pub fn time(&self, part: Part) -> Duration {
        self.times[part as usize]
    }

    /// Share of the image that the hand covered, on average.
    pub fn coverage(&self) -> f64 {
        self.covered as f64 / self.looked.max(1) as f64
    }
}
