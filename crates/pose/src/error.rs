//! What can be wrong with the settings and the data of filters and metrics.

/// A setting or a set of scores that cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PoseError {
    /// A setting lies outside its range.
    #[error("`{field}` is {value}; it must be {rule}")]
    OutOfRange {
        /// Name of the setting.
        field: &'static str,
        /// What it was set to.
        value: f64,
        /// What it may be.
        rule: &'static str,
    },
    /// Nothing was measured, so there is no score.
    #[error("no measurement of {what} in {sequences} sequences")]
    NothingMeasured {
        /// The quantity.
        what: &'static str,
        /// Sequences looked at.
        sequences: usize,
    },
    /// Two methods can only be compared on the same sequences.
    #[error("{left} sequences cannot be compared with {right}")]
    Unpaired {
        /// Sequences of the first method.
        left: usize,
        /// Sequences of the second method.
        right: usize,
    },
}
