//! Errors of exporting a network to ONNX.

/// Errors of this crate.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OnnxError {
    /// The exporter has no translation for an operation.
    #[error(
        "layer `{layer}`: the operation {operation} is not written as ONNX yet; it belongs in \
         crates/infer/src/onnx"
    )]
    Unsupported {
        /// Path of the layer.
        layer: String,
        /// Name of the operation.
        operation: String,
    },
    /// A layer cannot take an image of this size.
    #[error(transparent)]
    Shape(#[from] crate::InferError),
}
