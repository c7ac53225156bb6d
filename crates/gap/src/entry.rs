//! Entries of a summary: which statistic each is, and how it is compared.

use serde::{Deserialize, Serialize};

/// A family of statistics of the same property of events.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StatisticBlock {
    /// Events of pixels at rest.
    Quiet,
    /// Events per change of luminance, by brightness, speed and contrast.
    Crossing,
    /// Lags behind the reference.
    Timing,
    /// Change of log luminance between two events of a pixel.
    LogIntensityStep,
    /// Intervals between two events of a pixel.
    Interval,
    /// Events behind an edge.
    Tail,
    /// Differences between pixels.
    Spatial,
    /// Rates over frequency.
    Spectrum,
    /// Marks of readout and clock in the time stamps.
    Readout,
    /// Behaviour while many pixels have events at once.
    Load,
    /// Displacement of events in the image, against the reference.
    Geometry,
}

/// Scale on which a statistic is compared, with its tolerance. An infinite tolerance excludes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StatisticKind {
    /// A count `n` of events, compared as `2 sqrt(n + 3/8)` (Anscombe 1948), whose variance is one
    /// for independent events. The tolerance is one percent of the count plus this fraction of all
    /// events: bins have edges, and events at an edge may fall to either side.
    Count(f64),
    /// A value with an absolute tolerance.
    Value(f64),
}

/// One statistic of a summary.
#[derive(Debug, Clone)]
pub struct Entry {
    /// Family of statistics that it belongs to.
    pub block: StatisticBlock,
    /// Its name, unique within a family.
    pub name: String,
    /// Its scale and tolerance.
    pub kind: StatisticKind,
}

impl Entry {
    /// A count without a tolerance for the edges of bins.
    pub(crate) fn count(block: StatisticBlock, name: impl Into<String>) -> Self {
        Self { block, name: name.into(), kind: StatisticKind::Count(0.0) }
    }

    /// A value with an absolute tolerance.
    pub(crate) fn value(block: StatisticBlock, name: impl Into<String>, tolerance: f64) -> Self {
        Self { block, name: name.into(), kind: StatisticKind::Value(tolerance) }
    }

    /// Whether it is compared, which an infinite tolerance prevents.
    pub fn is_compared(&self) -> bool {
        let (StatisticKind::Count(tolerance) | StatisticKind::Value(tolerance)) = self.kind;
        tolerance.is_finite()
    }
}
