//! In how many bits a network computes, and what its layers need to know for the fewest.

use std::fmt;
use std::str::FromStr;

use evpose_kernels::blocked::{Scale, Storage};
use evpose_nn::graph::Graph;
use serde::{Deserialize, Serialize};

use crate::InferError;

/// How images and weights are kept on their way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Precision {
    /// In 32 bits, as the network was trained.
    #[default]
    F32,
    /// In the upper 16 of them.
    Bf16,
    /// In 8 bits, in steps that were measured: see [`CalibrationRanges`].
    Int8,
}

impl Precision {
    /// All there are, the most exact first.
    pub const ALL: [Self; 3] = [Self::F32, Self::Bf16, Self::Int8];
}

impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::F32 => "f32",
            Self::Bf16 => "bf16",
            Self::Int8 => "int8",
        })
    }
}

impl FromStr for Precision {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let all = Self::ALL.into_iter();
        all.into_iter()
            .find(|precision| precision.to_string() == word)
            .ok_or_else(|| format!("`{word}` is none of f32, bf16, int8"))
    }
}

/// The least and the largest value that the nodes of a graph were seen to make.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CalibrationRanges {
    nodes: Vec<NodeRange>,
}

/// What one node was seen to make.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct NodeRange {
    name: String,
    /// None where another does what the node says.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    range: Option<[f32; 2]>,
}

impl CalibrationRanges {
    /// Of a graph that was not seen to make anything.
    pub fn of(graph: &Graph) -> Self {
        let unseen = |name: &String| NodeRange { name: name.clone(), range: None };
        Self { nodes: graph.nodes.iter().map(|node| unseen(&node.name)).collect() }
    }

    /// Takes values of a node in.
    pub(crate) fn observe(&mut self, node: usize, [low, high]: [f32; 2]) {
        let range = &mut self.nodes[node].range;
        let [least, most] = range.unwrap_or([low, high]);
        *range = Some([least.min(low), most.max(high)]);
    }

    /// The step in which values of a node are kept in 8 bits.
    pub(crate) fn storage(&self, node: usize) -> Result<Storage, InferError> {
        let NodeRange { name, range } = &self.nodes[node];
        let is_usable = |[low, high]: &[f32; 2]| low.is_finite() && high.is_finite();
        let [low, high] = range
            .filter(is_usable)
            .ok_or_else(|| InferError::NotCalibrated { layer: name.clone() })?;
        Ok(Storage::Byte(Scale::of(low, high)))
    }

    /// # Errors
    /// If they are those of another graph.
    pub(crate) fn check(&self, graph: &Graph) -> Result<(), InferError> {
        let names = |node: &NodeRange| node.name.clone();
        let (mut ours, mut theirs) =
            (self.nodes.iter().map(names), graph.nodes.iter().map(|node| node.name.clone()));
        loop {
            match (ours.next(), theirs.next()) {
                (None, None) => return Ok(()),
                (one, other) if one == other => {}
                (one, other) => {
                    return Err(InferError::NotCalibrated {
                        layer: other.or(one).unwrap_or_default(),
                    });
                }
            }
        }
    }
}
