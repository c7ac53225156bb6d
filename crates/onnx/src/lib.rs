//! Networks as ONNX files, for other runtimes.
//!
//! [`model`] writes a [`Graph`](evpose_nn::graph::Graph) for images of one size, one at a time, with
//! normalisations folded into convolutions as in the graph. Operators are those of version 13 of the
//! standard set, which runtimes have had since 2021. Nodes and tensors carry the paths of layers.
//!
//! * `writer`: constants, nodes and names.
//! * `nodes`: what an operation is in operators of ONNX.
//! * [`proto`]: the messages of the format.

mod error;
mod nodes;
pub mod proto;
mod writer;

pub use error::OnnxError;
pub use prost::{DecodeError, Message};
pub use writer::{OPSET, encoded, model};
