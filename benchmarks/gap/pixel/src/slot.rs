//! Slots: parts of the camera of which there is one, and quantities that a recording gives but once.
//!
//! Two things in one slot do not make sense together. Either the second would take the place of the
//! first (a second readout, a second timer), or no recording could divide their sum (a delay of all
//! pixels and the zero of the clock; dark current, scattered light and a bias current, all of which
//! add a constant to the photocurrent).

use crate::oddity::Oddity;

/// A part or a quantity that one thing of a camera occupies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Slot {
    /// Light of the scene.
    Lamp,
    /// Point spread function.
    Lens,
    /// Constant addition to the photocurrent.
    AddedCurrent,
    /// Slope of the logarithm.
    Slope,
    /// Speed of the photoreceptor.
    Node,
    /// Noise of the photoreceptor.
    NodeNoise,
    /// Slow feedback.
    Feedback,
    /// Means of the thresholds.
    Thresholds,
    /// Thresholds pixel by pixel.
    Offsets,
    /// Noise of a comparison.
    ComparatorNoise,
    /// Level and time at which a reset ends.
    Reset,
    /// Leakage of the reset switch.
    Leak,
    /// Events of photon noise.
    PhotonEvents,
    /// Background rates that all pixels share.
    BackgroundRate,
    /// Pixels that fire by themselves.
    HotPixels,
    /// Order in which pixels are read.
    Access,
    /// Events that the readout adds or loses.
    Losses,
    /// Delays that differ from event to event or from pixel to pixel.
    Jitter,
    /// Period of the counter.
    Counter,
    /// Constant delay and zero of the clock.
    Delay,
}

impl Oddity {
    /// The slot that the effect occupies.
    pub fn slot(self) -> Slot {
        match self {
            Self::EventEcho | Self::CorrelatedLoss | Self::NeighbourCopy => Slot::Losses,
            Self::SmoothThresholds | Self::LightDependentMismatch => Slot::Offsets,
            Self::OneSidedRefractory | Self::Hysteresis | Self::ChargeInjection => Slot::Reset,
        }
    }
}
