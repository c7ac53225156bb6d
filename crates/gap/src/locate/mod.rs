//! Localisation of the disagreement of measured and simulated events: in light, image, time, and
//! time after a change of luminance.
//!
//! ```text
//! measured events + runs of the model
//!   -> Table        event counts of every class, see [`Axis`]
//!   -> Attribution  fraction of the disagreement that each axis explains
//!   -> Scan         the classes in which it is largest, described by a sentence
//!   -> Maps         residuals over the image, its rows and columns, and time
//!   -> Response     the law of the difference along each property
//! ```
//!
//! Counts are compared with those of several runs of the model. Differences among the runs give the
//! distribution by chance.

mod arrows;
mod attribution;
mod axis;
mod maps;
mod property;
mod region;
mod response;
mod scan;
mod significance;
mod table;
mod term;
#[cfg(test)]
mod tests;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::View;
use crate::verdict::Location;

pub use arrows::Arrow;
pub use attribution::{Attribution, Explained};
pub use axis::Axis;
pub use maps::{Maps, OddPixel, Profile, ResidualImage};
pub use property::Property;
pub use region::Region;
pub use response::{Response, ResponseFit, ResponseForm, ResponsePoint, ResponseShape};
pub use scan::Scan;

use table::Table;

/// Hot pixels are reported with a region of whose excess they have at least this fraction.
const HOT: f64 = 0.5;

/// Location of the disagreement of a recording and a model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Located {
    /// Fraction of the disagreement that each axis explains.
    pub attribution: Attribution,
    /// Classes of events in which it is largest.
    pub scan: Scan,
    /// Residuals over image and time.
    pub maps: Maps,
    /// Laws of the difference along each property, that which describes most first.
    pub responses: Vec<Response>,
}

impl Located {
    /// Summary for the verdict.
    pub fn location(&self) -> Location {
        let mut sentence = self.scan.sentence.clone();
        let Maps { hot, hot_events, .. } = self.maps;
        let region = self.scan.regions.first();
        // Regions are ranges of light and place: only the map resolves single pixels.
        if hot > 0 && region.is_some_and(|r| hot_events > HOT * (r.measured - r.expected).abs()) {
            sentence +=
                &format!(" Of hot pixels there are {hot}, with {hot_events:.0} events too many.");
        }
        Location { sentence, shares: self.attribution.shares() }
    }
}

/// Compares measured events with runs of a model on the same scene and window.
///
/// Four runs locate the disagreement; eight do so with confidence. Fewer than two locate nothing.
pub fn locate(measured: &View<'_>, runs: &[View<'_>]) -> Located {
    let streams: Vec<&View<'_>> = std::iter::once(measured).chain(runs).collect();
    if runs.len() < 2 {
        return Located { scan: Scan::of_too_few_runs(), ..Located::default() };
    }
    let table = Table::from_views(&streams);
    let samples: Vec<_> = (0..streams.len()).into_par_iter().map(|i| table.sample(i)).collect();
    let (scan, (attribution, maps)) = rayon::join(
        || scan::scan(&table, &samples, measured),
        || (attribution::attribute(&table, &samples), maps::maps(measured, runs)),
    );
    let responses = response::responses(measured, runs);
    Located { attribution, scan, maps, responses }
}
