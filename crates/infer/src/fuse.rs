//! Sums and activations that go into the convolution before them.

use evpose_nn::graph::{Activation, Graph, NodeId, Operation};

/// What is left to do at a node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Fused {
    /// What the node says.
    Whole,
    /// A convolution with what came behind it.
    Conv {
        /// The node of the convolution.
        conv: NodeId,
        /// What is added to its sums.
        residual: Option<NodeId>,
        /// What becomes of them.
        activation: Activation,
    },
    /// A sum and its activation.
    Sum {
        /// What is added.
        of: [NodeId; 2],
        /// What becomes of it.
        activation: Activation,
    },
    /// Another node does it.
    Elsewhere,
}

/// What to do at every node. A convolution takes up the sum and the activation that are the only ones to
/// see it, and is done where the last of them was.
pub(crate) fn fused(graph: &Graph) -> Vec<Fused> {
    let mut seen = vec![0; graph.nodes.len()];
    graph.nodes.iter().flat_map(|node| &node.inputs).for_each(|id| seen[*id] += 1);
    graph.outputs.iter().for_each(|id| seen[*id] += 1);
    let mut fused: Vec<Fused> = Vec::with_capacity(graph.nodes.len());
    for (id, node) in graph.nodes.iter().enumerate() {
        let new = match &node.operation {
            Operation::Conv(conv) => {
                Fused::Conv { conv: id, residual: None, activation: conv.activation }
            }
            Operation::Add => {
                let of = [node.inputs[0], node.inputs[1]];
                // The later one: what is added is there by then.
                let (last, other) = (of[0].max(of[1]), of[0].min(of[1]));
                match &fused[last] {
                    Fused::Conv { conv, residual: None, activation: Activation::Identity }
                        if seen[last] == 1 && other != last =>
                    {
                        let conv = *conv;
                        fused[last] = Fused::Elsewhere;
                        let activation = Activation::Identity;
                        Fused::Conv { conv, residual: Some(other), activation }
                    }
                    _ => Fused::Sum { of, activation: Activation::Identity },
                }
            }
            Operation::Relu => {
                let from = node.inputs[0];
                let mut taken = fused[from].clone();
                match &mut taken {
                    Fused::Conv { activation, .. } | Fused::Sum { activation, .. }
                        if *activation == Activation::Identity && seen[from] == 1 =>
                    {
                        *activation = Activation::Relu;
                        fused[from] = Fused::Elsewhere;
                        taken
                    }
                    _ => Fused::Whole,
                }
            }
            _ => Fused::Whole,
        };
        fused.push(new);
    }
    fused
}
