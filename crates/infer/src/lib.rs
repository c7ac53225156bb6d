//! Inference on the CPU, one image at a time, faster than the framework that trains.
//!
//! A network is defined once, in Burn, and written down as a [`Graph`](evpose_nn::graph::Graph),
//! with its normalisations folded into convolutions. [`Engine::compile`] makes a plan of it: what
//! can be done in one pass is fused, every layer gets the algorithm that suits it, weights are laid
//! out for it, and all memory is set aside. [`Engine::run`] then only computes.
//!
//! * `shapes`: what sizes images have on their way.
//! * `fuse`: sums and activations that go into the convolution before them.
//! * `plan`: steps in order, in which bits their images are kept, and where.
//! * `chain`: which steps are done together.
//! * `held`: images, however they are kept.
//! * `memory`: which images share the same memory.
//! * `step`: the operations of a plan.
//! * [`Engine`]: a plan that runs.

mod chain;
mod engine;
mod error;
mod fuse;
mod held;
mod memory;
mod plan;
mod precision;
mod shapes;
mod step;

pub use engine::{Engine, EngineOptions, Layer};
pub use error::InferError;
pub use evpose_kernels::Level;
pub use precision::{CalibrationRanges, Precision};
pub use shapes::{Shape, shapes};
