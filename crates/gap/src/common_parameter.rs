//! Parameters that every description of an event camera has values of.

/// A parameter that every description of an event camera has a value of. The stage that owns it
/// says so in its `SearchSpec`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommonParameter {
    /// Threshold of ON events, ln.
    ThresholdOn,
    /// Threshold of OFF events, ln.
    ThresholdOff,
    /// Standard deviation of thresholds from pixel to pixel, ln.
    ThresholdMismatch,
    /// Background rate of ON events per pixel, Hz.
    NoiseOn,
    /// Background rate of OFF events per pixel, Hz.
    NoiseOff,
    /// Delay of the clock, microseconds.
    ClockOffset,
    /// Light that is added before the logarithm, relative to white.
    DarkOffset,
}

impl CommonParameter {
    /// All parameters, in the order of reports.
    pub const ALL: [Self; 7] = [
        Self::ThresholdOn,
        Self::ThresholdOff,
        Self::ThresholdMismatch,
        Self::NoiseOn,
        Self::NoiseOff,
        Self::ClockOffset,
        Self::DarkOffset,
    ];
}
