//! Inference on the CPU, one image at a time, faster than the framework that trains.
//!
//! A network is defined once, in Burn, and exported as a [`Graph`](evpose_nn::graph::Graph) with
//! its batch normalisations folded into convolutions. [`Engine::compile`] compiles the graph to a
//! plan: layers are fused, each layer gets the algorithm that is fastest for its shape, weights are
//! packed, and all memory is allocated. [`Engine::run`] then only computes.
//!
//! ```
//! use evpose_infer::{Engine, EngineOptions};
//! use evpose_nn::graph::{Activation, ConvLayer, Graph, Node, Operation};
//!
//! // A 1x1 convolution of one channel, relu(2 x - 1).
//! let conv = ConvLayer {
//!     shape: [1, 1, 1, 1],
//!     groups: 1,
//!     stride: [1, 1],
//!     padding: [0; 4],
//!     dilation: [1, 1],
//!     weight: vec![2.0],
//!     bias: vec![-1.0],
//!     activation: Activation::Relu,
//! };
//! let node = |name: &str, operation, inputs| Node { name: name.to_owned(), operation, inputs, channels: 1 };
//! let graph = Graph {
//!     nodes: vec![
//!         node("input", Operation::Input, vec![]),
//!         node("conv", Operation::Conv(conv), vec![0]),
//!     ],
//!     outputs: vec![1],
//! };
//!
//! let mut engine = Engine::compile(&graph, [1, 1, 4], EngineOptions::default())?;
//! assert_eq!(engine.run(&[0.0, 1.0, 2.0, 3.0]), [vec![0.0, 1.0, 3.0, 5.0]]);
//! assert_eq!(engine.layers()[0].macs, 4);
//! # Ok::<(), evpose_infer::InferError>(())
//! ```
//!
//! From the graph to the result:
//!
//! * `shapes`: shape inference.
//! * `fuse`: residual sums and activations that become epilogues of the convolution before them.
//! * `plan`: the steps in order, with the storage type of each value.
//! * `chain`: consecutive steps that are fused and run a band of rows at a time.
//! * `allocation`, `memory`: buffers of the values, shared between values that do not live at the
//!   same time.
//! * `step`: the operators of a plan.
//! * `buffer`: an image in the storage type of its value.
//! * [`Engine`]: a plan with its buffers and threads.
//!
//! [`onnx`] writes networks for other runtimes.

mod allocation;
mod buffer;
mod chain;
mod engine;
mod error;
mod fuse;
mod layer;
mod memory;
pub mod onnx;
mod plan;
mod precision;
mod shapes;
mod step;

pub use engine::{Engine, EngineOptions};
pub use error::InferError;
pub use evpose_kernels::Level;
pub use layer::Layer;
pub use precision::{CalibrationRanges, Precision};
pub use shapes::{Shape, infer_shapes};
