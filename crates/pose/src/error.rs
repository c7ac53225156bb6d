//! What can be wrong with the settings of filters and the use of metrics.

/// A setting or a comparison that makes no sense.
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
    /// Two methods can only be compared on the same sequences.
    #[error("{left} sequences cannot be compared with {right}")]
    Unpaired {
        /// Sequences of the first method.
        left: usize,
        /// Sequences of the second method.
        right: usize,
    },
    /// A number of a pose is infinite or none.
    #[error("{what} {row} (the first is 0) holds a number that is not finite")]
    NotFinite {
        /// `label` or `prediction`.
        what: &'static str,
        /// Which one.
        row: usize,
    },
    /// A sequence without a label cannot be judged.
    #[error("the sequence has no labels")]
    NoLabels,
}
