//! Errors of compiling a network.

/// Errors of this crate.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum InferError {
    /// The engine has no kernel for a layer.
    #[error(
        "layer `{layer}`: the engine has no {operation}; other devices may (Cargo features ndarray, wgpu, cuda)"
    )]
    Unsupported {
        /// Path of the layer.
        layer: String,
        /// The unsupported operation.
        operation: String,
    },
    /// The input of a layer has a shape that the layer cannot take.
    #[error("layer `{layer}`: {problem}")]
    Shape {
        /// Path of the layer.
        layer: String,
        /// Expected and actual shape, as a sentence.
        problem: String,
    },
    /// The processor does not have the requested instructions.
    #[error("this processor has no {level}")]
    Level {
        /// The requested level.
        level: String,
    },
    /// A word that is no name of a precision.
    #[error("`{0}` is none of f32, bf16, int8")]
    UnknownPrecision(String),
    /// Int8 inference of a layer without a calibration range.
    #[error(
        "layer `{layer}`: its values were not measured for 8 bits; `evpose quantize` does that with a data set"
    )]
    NotCalibrated {
        /// Path of the layer.
        layer: String,
    },
}
