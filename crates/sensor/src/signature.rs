//! How an effect shows: what to look for, in which measurement, and how strong it is in cameras.

/// The observation that distinguishes an effect from others.
#[derive(Debug, Clone, Copy)]
pub struct Signature {
    /// Appearance in events or in the measurement.
    pub look_for: &'static str,
    /// The measurement in which it stands out.
    pub probe: Probe,
    /// The parameters that make it stronger.
    pub strength: Strength,
    /// Other effects, at typical values, without which it changes nothing.
    pub beside: &'static [&'static str],
}

/// A measurement of events, or of a signal inside the chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Probe {
    /// Events of a moving scene, as an event image.
    EventImage,
    /// Events of a grid of straight lines that appears, as an event image.
    Grid,
    /// Voltage of a bright and of a dark pixel behind a step of light.
    StepResponse,
    /// The same, of light that is known every 10 ms only.
    CoarseStepResponse,
    /// Voltage, memory and events of one pixel.
    Trace,
    /// How many thresholds a change of light is worth, by the light it starts from.
    Contrast,
    /// Events of a moving grating, by its period.
    Grating,
    /// Events of every pixel, all of which see the same ramps of light.
    RampMap,
    /// Events of every pixel of a scene at rest.
    RestMap,
    /// Times between the events of a pixel at rest.
    RestIntervals,
    /// The same over times of milliseconds, by whether the next event has the same sign.
    NoisePairs,
    /// Times between the events of a pixel whose light changes all the time.
    BusyIntervals,
    /// Event rates at rest, by the distance from the centre of the image.
    RateByRadius,
    /// Event rates at rest, by light.
    RateByLight,
    /// Event rates over time while the light of the scene is steady.
    RateOverTime,
    /// Row and time of each event behind a flash.
    FlashRaster,
    /// Event rates over time behind flashes.
    FlashRate,
    /// Difference between stamps and the times of the ideal sensor.
    StampError,
}

/// The parameters that make an effect stronger together.
#[derive(Debug, Clone, Copy)]
pub enum Strength {
    /// By growing.
    Rising(&'static [&'static str]),
    /// By growing, where the other parameters are another form of the effect.
    RisingAlone(&'static [&'static str]),
    /// By getting smaller.
    Falling(&'static [&'static str]),
    /// There is nothing to set.
    Unchanging,
    /// By what files, or a formula, of the user say; without them it does nothing.
    FromFiles,
}
