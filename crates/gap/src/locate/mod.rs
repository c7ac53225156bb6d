//! Where measured and simulated events disagree: in which light, which part of the image, when, and
//! how long after a change.
//!
//! ```text
//! measured events + runs of the model
//!   -> Table        how many events each has of every class, see [`Axis`]
//!   -> Attribution  what share of the disagreement each axis explains
//!   -> Scan         the classes in which it is largest, and a sentence that says so
//!   -> Maps         residuals over the image, its rows and columns, and time
//! ```
//!
//! All of it compares numbers of events with those of several runs of the model. What such runs do
//! among themselves is what chance does.

mod arrows;
mod attribution;
mod axis;
mod maps;
mod region;
mod scan;
mod significance;
mod table;
mod term;
#[cfg(test)]
mod tests;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::View;
use crate::verdict::Where;

pub use arrows::Arrow;
pub use attribution::{Attribution, Explained};
pub use axis::Axis;
pub use maps::{Maps, OddPixel, Profile, ResidualImage};
pub use region::Region;
pub use scan::Scan;

use table::Table;

/// Hot pixels are told with a region that they have this part of, at least.
const HOT: f64 = 0.5;

/// Where a recording and a model disagree.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Located {
    /// What share of the disagreement each axis explains.
    pub attribution: Attribution,
    /// The classes of events in which it is largest.
    pub scan: Scan,
    /// Residuals over image and time.
    pub maps: Maps,
}

impl Located {
    /// The same in the form of the verdict.
    pub fn place(&self) -> Where {
        let mut sentence = self.scan.sentence.clone();
        let Maps { hot, hot_events, .. } = self.maps;
        let region = self.scan.regions.first();
        // Regions are of light and place: only the map sees single pixels.
        if hot > 0 && region.is_some_and(|r| hot_events > HOT * (r.measured - r.expected).abs()) {
            sentence +=
                &format!(" Of hot pixels there are {hot}, with {hot_events:.0} events too many.");
        }
        Where { sentence, shares: self.attribution.shares() }
    }
}

/// Compares measured events with runs of a model on the same stage and window.
///
/// Four runs say where; eight say it with confidence. With fewer than two nothing is said.
pub fn locate(measured: &View<'_>, runs: &[View<'_>]) -> Located {
    let streams: Vec<&View<'_>> = std::iter::once(measured).chain(runs).collect();
    if runs.len() < 2 {
        return Located { scan: Scan::of_too_few_runs(), ..Located::default() };
    }
    let table = Table::of(&streams);
    let samples: Vec<_> = (0..streams.len()).into_par_iter().map(|i| table.sample(i)).collect();
    let (scan, (attribution, maps)) = rayon::join(
        || scan::scan(&table, &samples, measured),
        || (attribution::attribute(&table, &samples), maps::maps(measured, runs)),
    );
    Located { attribution, scan, maps }
}
