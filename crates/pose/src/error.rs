//! Errors of filter settings and of the use of metrics.

/// A setting out of range, or data that a metric is not defined for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PoseError {
    /// A setting lies outside its range.
    #[error("`{field}` is {value}; it must be {rule}")]
    OutOfRange {
        /// Name of the setting.
        field: &'static str,
        /// Value that was given.
        value: f64,
        /// Allowed values, in words.
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
    /// A value of a pose is infinite or NaN.
    #[error("{what} {row} (the first is 0) holds a value that is not finite")]
    NotFinite {
        /// `label` or `prediction`.
        what: &'static str,
        /// Index of the label or prediction.
        row: usize,
    },
    /// A sequence without labels cannot be evaluated.
    #[error("the sequence has no labels")]
    NoLabels,
}

impl PoseError {
    /// [`Self::OutOfRange`] unless the value is allowed.
    pub(crate) fn unless(
        is_allowed: bool,
        field: &'static str,
        value: impl Into<f64>,
        rule: &'static str,
    ) -> Result<(), Self> {
        // Asked for what is allowed, not for what is refused: NaN compares as neither.
        if is_allowed { Ok(()) } else { Err(Self::OutOfRange { field, value: value.into(), rule }) }
    }
}
