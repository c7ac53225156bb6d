//! What can go wrong when a network is written as ONNX.

/// Errors of this crate.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OnnxError {
    /// There is no way yet to say an operation in ONNX.
    #[error(
        "layer `{layer}`: the operation {operation} is not written as ONNX yet; it belongs in \
         crates/onnx"
    )]
    Unsupported {
        /// The path of the layer.
        layer: String,
        /// What it does.
        operation: String,
    },
    /// Images of this size do not go through the network.
    #[error(transparent)]
    Shape(#[from] evpose_infer::InferError),
}
