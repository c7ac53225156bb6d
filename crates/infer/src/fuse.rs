//! Fusion of residual sums and activations into the convolution before them.

use evpose_nn::graph::{Activation, Graph, NodeId, Operation};

/// The operation that a plan runs at a node, after fusion.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum FusedOp {
    /// The node's own operation.
    Unfused,
    /// A convolution with its epilogue.
    Conv {
        conv: NodeId,
        /// Node that is added to the sums.
        residual: Option<NodeId>,
        /// Activation after that.
        activation: Activation,
    },
    /// A sum with its activation.
    Add {
        /// Nodes whose outputs are added.
        inputs: [NodeId; 2],
        /// Activation of the sum.
        activation: Activation,
    },
    /// Nothing: the operation is part of a later node's.
    Absorbed,
}

/// Operation of each node after fusion. A convolution absorbs the sum and the activation that are
/// its only users, and runs at the node of the last of them.
pub(crate) fn fuse(graph: &Graph) -> Vec<FusedOp> {
    // What a second node or the caller reads has to be written: it is not absorbed.
    let mut uses = vec![0; graph.nodes.len()];
    graph.nodes.iter().flat_map(|node| &node.inputs).for_each(|id| uses[*id] += 1);
    graph.outputs.iter().for_each(|id| uses[*id] += 1);
    let mut fused: Vec<FusedOp> = Vec::with_capacity(graph.nodes.len());
    for (id, node) in graph.nodes.iter().enumerate() {
        let op = match &node.operation {
            Operation::Conv(conv) => {
                FusedOp::Conv { conv: id, residual: None, activation: conv.activation }
            }
            Operation::Add => {
                let inputs = [node.inputs[0], node.inputs[1]];
                // The later summand absorbs the sum: the other is computed by then.
                let (last, other) = (inputs[0].max(inputs[1]), inputs[0].min(inputs[1]));
                match &fused[last] {
                    FusedOp::Conv { conv, residual: None, activation: Activation::Identity }
                        if uses[last] == 1 && other != last =>
                    {
                        let conv = *conv;
                        fused[last] = FusedOp::Absorbed;
                        let activation = Activation::Identity;
                        FusedOp::Conv { conv, residual: Some(other), activation }
                    }
                    _ => FusedOp::Add { inputs, activation: Activation::Identity },
                }
            }
            Operation::Relu => {
                let input = node.inputs[0];
                // The activation's node takes over the operation, which then runs once, with its
                // epilogue.
                let mut op = fused[input].clone();
                match &mut op {
                    FusedOp::Conv { activation, .. } | FusedOp::Add { activation, .. }
                        if *activation == Activation::Identity && uses[input] == 1 =>
                    {
                        *activation = Activation::Relu;
                        fused[input] = FusedOp::Absorbed;
                        op
                    }
                    _ => FusedOp::Unfused,
                }
            }
            _ => FusedOp::Unfused,
        };
        fused.push(op);
    }
    fused
}
