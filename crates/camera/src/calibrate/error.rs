//! Errors of calibration.

use evpose_core::SensorSize;

/// Why there is nothing to calibrate with.
#[derive(Debug, thiserror::Error)]
pub enum CalibrateError {
    /// Frames and events are of different sizes.
    #[error("frames of {frames} and events of a sensor of {events}: both must be of one camera")]
    Size {
        /// Of frames.
        frames: SensorSize,
        /// Of events.
        events: SensorSize,
    },
    /// Fewer than two frames.
    #[error("{0} frames: at least two are needed, between which light changes")]
    TooFewFrames(usize),
    /// Too few events to say anything.
    #[error("{actual} {what}: at least {needed} are needed; record for longer, or more motion")]
    TooFewEvents {
        /// Kind of the events.
        what: &'static str,
        /// Number of events in the recording.
        actual: usize,
        /// Minimum number of events.
        needed: usize,
    },
    /// Light that does not change.
    #[error("light does not change in these frames: a moving pattern is needed")]
    NoChange,
    /// A recording without length.
    #[error("a recording of {0} s: at least {1} s are needed")]
    TooShort(f64, f64),
}
