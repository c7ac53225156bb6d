//! Why a measurement cannot be used.

use evpose_core::Micros;

/// A measurement that does not fit what is known. It is left out; all else stays as it was.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FusionError {
    /// It describes a time before everything that is remembered.
    #[error(
        "a measurement of {t} comes too late: nothing before {oldest} is remembered; raise `history_s`, or reset if \
         the stream started again"
    )]
    TooLate {
        /// The time it describes.
        t: Micros,
        /// The earliest time that it could describe.
        oldest: Micros,
    },
    /// A detection describes a time after the one at which it was made.
    #[error(
        "a detection of {t} cannot have been made at {now}; both must be on the clock of the events"
    )]
    NotYet {
        /// The time it describes.
        t: Micros,
        /// When it was made.
        now: Micros,
    },
}
