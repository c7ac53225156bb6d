//! Marks that effects leave in the times and places of events.

/// A mark of an effect in a recording, so that its parameters can be read off without a
/// simulation. The stage has the [parameters](Self::parameters) that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum RecordingMark {
    /// Light that rises and falls: a spectral line of the ON rate minus the OFF rate.
    Lamp,
    /// Successive events of a pixel at rest have opposite polarities.
    Alternation,
    /// ON events of pixels at rest at regular intervals.
    RegularOn,
    /// A shortest interval between events of a pixel.
    DeadTime,
    /// Pixels without events where their neighbours have many.
    SilentPixels,
    /// Pixels with far more events than their neighbours.
    HotPixels,
    /// Events of pixels at rest at random times.
    RandomRest,
    /// Intervals between successive events that a bus sets.
    Bus,
    /// Times of the events of a line that repeat with the scan of all lines.
    Scan,
    /// A rate of all events that is never exceeded.
    RateCeiling,
    /// Times that are multiples of a period.
    TimeGrid,
    /// Events of slow changes at equal steps of light.
    LightSteps,
}

impl RecordingMark {
    pub(crate) const ALL: [Self; 12] = [
        Self::Lamp,
        Self::Alternation,
        Self::RegularOn,
        Self::DeadTime,
        Self::SilentPixels,
        Self::HotPixels,
        Self::RandomRest,
        Self::Bus,
        Self::Scan,
        Self::RateCeiling,
        Self::TimeGrid,
        Self::LightSteps,
    ];

    /// Keys of the parameters and choices that may be read off, in the units of their names.
    #[cfg(test)]
    pub(crate) fn parameters(self) -> &'static [&'static str] {
        match self {
            Self::Lamp => &["frequency_hz", "phase_turns"],
            Self::Alternation => &[],
            Self::RegularOn => &["rate_hz", "jitter"],
            Self::RandomRest => &["on_hz", "off_hz"],
            Self::DeadTime | Self::TimeGrid => &["period_us"],
            Self::LightSteps => &["levels"],
            Self::SilentPixels => &["fraction"],
            Self::HotPixels => &["fraction", "median_hz", "on_share"],
            Self::Bus => &["rate_hz", "row_ns"],
            Self::Scan => &["axis", "direction", "period_us"],
            Self::RateCeiling => &["rate_hz", "window_us", "phase_us"],
        }
    }
}
