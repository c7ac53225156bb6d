//! Formulas by what they act on.

use super::events::EventFormula;
use super::front::FrontFormula;
use super::pixels::PixelFormula;
use crate::Domain;

/// A formula at the stage that it acts at.
#[derive(Debug)]
pub enum Formula {
    /// Acts on light or voltage.
    Front(FrontFormula),
    /// Acts on thresholds or refractory periods of pixels.
    Pixels(PixelFormula),
    /// Acts on events that are read out.
    Events(EventFormula),
}

impl Formula {
    /// Place of the formula in the signal path.
    pub fn domain(&self) -> Domain {
        match self {
            Self::Front(front) => front.domain(),
            Self::Pixels(_) => Domain::Detector,
            Self::Events(_) => Domain::Readout,
        }
    }
}
