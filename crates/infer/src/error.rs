//! What can go wrong when a network is compiled.

/// Errors of this crate.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum InferError {
    /// The engine has no kernel for a layer.
    #[error("layer `{layer}`: the engine has no {what}; run this network on the device flex")]
    Unsupported {
        /// The path of the layer.
        layer: String,
        /// What is missing.
        what: String,
    },
    /// A layer is given something that it does not fit.
    #[error("layer `{layer}`: {problem}")]
    Shape {
        /// The path of the layer.
        layer: String,
        /// What is wrong.
        problem: String,
    },
    /// The processor has no such instructions.
    #[error("this processor has no {level}")]
    Level {
        /// What was asked for.
        level: String,
    },
    /// Nothing is known of the values that a layer makes.
    #[error(
        "layer `{layer}`: its values were not measured for 8 bits; `evpose quantize` does that with a data set"
    )]
    NotCalibrated {
        /// The path of the layer.
        layer: String,
    },
}
