//! Export of networks to ONNX, for other runtimes.
//!
//! [`model`] exports a [`Graph`](evpose_nn::graph::Graph) for images of one size and batch size 1, or, with an
//! [`Interface`], for any batch size, with names and metadata for others. Batch normalisations are folded into
//! convolutions as in the graph. It uses operators of opset 13 of the default domain, which runtimes support
//! since 2021. Nodes and tensors are named by the paths of layers.
//!
//! ```
//! use evpose_nn::graph::{Graph, Node, Operation};
//! use evpose_infer::onnx::{Message, encoded, proto::ModelProto};
//!
//! let node = |name: &str, operation, inputs| Node { name: name.to_owned(), operation, inputs, channels: 2 };
//! let graph = Graph {
//!     nodes: vec![
//!         node("input", Operation::Input, vec![]),
//!         node("relu", Operation::Relu, vec![0]),
//!     ],
//!     outputs: vec![1],
//! };
//!
//! let file = encoded(&graph, [2, 4, 6])?;
//! let model = ModelProto::decode(file.as_slice())?;
//! let graph = model.graph.unwrap_or_default();
//! assert_eq!(graph.node.len(), 1);
//! assert_eq!(graph.node[0].op_type, "Relu");
//! assert_eq!((graph.input[0].name.as_str(), graph.output[0].name.as_str()), ("input", "relu"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! * `writer`: initializers, nodes and names of a file.
//! * `nodes`: translation of operations to ONNX operators.
//! * [`proto`]: the messages of the file format.

mod error;
mod nodes;
pub mod proto;
mod writer;

pub use error::OnnxError;
pub use prost::{DecodeError, Message};
pub use writer::{BATCH, Interface, OPSET, encoded, model};
