//! Description of the layers of a compiled network.

/// A layer of a plan: one step, which may fuse several layers of the network.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Path of the layer in the network, or its operation.
    pub name: String,
    /// Name of its algorithm.
    pub algorithm: &'static str,
    /// Channels, height and width of the output.
    pub output: [usize; 3],
    /// Multiply-accumulates by the definition of the layer, whatever the algorithm needs.
    pub macs: u64,
    /// Weights and biases.
    pub weights: u64,
    /// Bytes of weights, inputs and output, each moved once, in f32.
    pub bytes: u64,
}
