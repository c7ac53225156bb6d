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
    /// independent. Differences of a hundredth do not matter.
    Count,
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

    /// The numbers of a view, each on the scale on which it is compared.
    pub fn summarise(&self, view: &View<'_>) -> Vec<f64> {
        let mut numbers = Vec::with_capacity(self.entries.len());
        for probe in PROBES {
            probe.measure(view, &mut numbers);
        }
        debug_assert_eq!(numbers.len(), self.entries.len());
        for (number, entry) in numbers.iter_mut().zip(&self.entries) {
            if entry.kind == Kind::Count {
                *number = 2.0 * (*number + 0.375).sqrt();
            }
        }
        numbers
    }

    /// What difference of an entry does not matter, at a value of it.
    pub fn tolerance(&self, entry: usize, value: f64) -> f64 {
        match self.entries[entry].kind {
            Kind::Count => 0.5 * COUNT_TOLERANCE * value,
            Kind::Number(tolerance) => tolerance,
        }
    }
}
