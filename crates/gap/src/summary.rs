//! A recording as one vector of numbers, the same numbers for whatever made the events.

use crate::View;
use crate::probe::PROBES;

/// A family of numbers that say the same thing about events.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "snake_case")]
pub enum Block {
    /// Events of pixels at rest.
    Quiet,
    /// Events per change of light, by brightness, speed and contrast.
    Crossing,
    /// Times against the reference.
    Timing,
    /// Change of log light between two events of a pixel.
    Swing,
    /// Times between two events of a pixel.
    Interval,
    /// Events behind an edge.
    Tail,
    /// How events differ from pixel to pixel.
    Spatial,
    /// Rates over frequency.
    Spectrum,
    /// Marks of readout and clock in the stamps.
    Readout,
    /// What happens when many pixels have events at once.
    Load,
    /// Where in the image events are against where the reference has them.
    Geometry,
}

/// How a number is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A number of events `n`, compared as `2 sqrt(n + 3/8)`, whose variance is one if they are
    /// independent. Differences of a hundredth do not matter, nor do those up to this share of all
    /// events: bins have edges, and events at an edge go either way.
    Count(f64),
    /// A number of which differences up to this do not matter.
    Number(f64),
}

/// One number of a summary.
#[derive(Debug, Clone)]
pub struct Entry {
    /// Its family.
    pub block: Block,
    /// What it is.
    pub name: String,
    /// How it is compared.
    pub kind: Kind,
}

impl Entry {
    /// Whether any difference of it matters.
    pub fn is_compared(&self) -> bool {
        let (Kind::Count(tolerance) | Kind::Number(tolerance)) = self.kind;
        tolerance.is_finite()
    }
}

/// Summaries of one stage have these entries.
#[derive(Debug, Clone)]
pub struct Layout {
    /// All entries, probe after probe.
    pub entries: Vec<Entry>,
}

/// Share of a count of which differences do not matter.
const COUNT_TOLERANCE: f64 = 0.01;

impl Layout {
    /// Entries of all probes.
    pub fn of_all_probes() -> Self {
        Self { entries: PROBES.iter().flat_map(|probe| probe.entries()).collect() }
    }

    /// The same, of which only those of some blocks are compared.
    pub fn of_blocks(is_compared: impl Fn(Block) -> bool) -> Self {
        let mut layout = Self::of_all_probes();
        for entry in layout.entries.iter_mut().filter(|entry| !is_compared(entry.block)) {
            let (Kind::Count(tolerance) | Kind::Number(tolerance)) = &mut entry.kind;
            *tolerance = f64::INFINITY;
        }
        layout
    }

    /// The numbers of a view, each on the scale on which it is compared.
    pub fn summarise(&self, view: &View<'_>) -> Vec<f64> {
        let mut numbers = Vec::with_capacity(self.entries.len());
        for probe in PROBES {
            probe.measure(view, &mut numbers);
        }
        debug_assert_eq!(numbers.len(), self.entries.len());
        for (number, entry) in numbers.iter_mut().zip(&self.entries) {
            if let Kind::Count(_) = entry.kind {
                *number = 2.0 * (*number + 0.375).sqrt();
            }
        }
        numbers
    }

    /// What difference of an entry does not matter, at a value of it among so many events.
    pub fn tolerance(&self, entry: usize, value: f64, events: f64) -> f64 {
        match self.entries[entry].kind {
            // The derivative of the scale takes numbers of events to differences on it.
            Kind::Count(share) => {
                let events_of_entry = 0.25 * value * value;
                (COUNT_TOLERANCE * events_of_entry + share * events) * 2.0 / value.max(1.0)
            }
            Kind::Number(tolerance) => tolerance,
        }
    }

    /// OFF and ON events of a summary while light changes.
    pub fn events_in_motion(&self, summary: &[f64]) -> [f64; 2] {
        let mut counts = [0.0; 2];
        for (i, value) in summary.iter().take(crate::probe::ALL_EVENTS).enumerate() {
            // Entries go by polarity first, then by speed, of which the first is rest.
            if i / 2 % crate::Cell::SPEEDS > 0 {
                counts[i % 2] += (0.25 * value * value - 0.375).max(0.0);
            }
        }
        counts
    }

    /// The events of a summary in all: those of the histogram that has every event once.
    pub fn events(&self, summary: &[f64]) -> f64 {
        let all = self.entries.iter().zip(summary).take(crate::probe::ALL_EVENTS);
        all.map(|(_, value)| 0.25 * value * value - 0.375).sum()
    }
}
