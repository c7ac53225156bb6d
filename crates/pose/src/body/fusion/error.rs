//! Measurements that cannot be fused.

use evpose_core::Micros;

/// A measurement out of the time range. It is ignored, and the state is unchanged.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FusionError {
    /// Its event time stamp is before the history.
    #[error(
        "a measurement of {t} comes too late: nothing before {oldest} is remembered; raise `history_s`, or reset if \
         the stream started again"
    )]
    TooLate {
        /// Its event time stamp.
        t: Micros,
        /// Beginning of the history.
        oldest: Micros,
    },
    /// The event time stamp of a detection is after its arrival.
    #[error(
        "a detection of {t} cannot have been made at {now}; both must be on the clock of the events"
    )]
    NotYet {
        /// Its event time stamp.
        t: Micros,
        /// Time of its arrival.
        now: Micros,
    },
}
