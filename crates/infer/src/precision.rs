//! Precision of inference, and the calibration ranges of int8.

use std::fmt;
use std::str::FromStr;

use evpose_kernels::blocked::{LowPrecisionType, QuantizationParams};
use evpose_nn::graph::Graph;
use serde::{Deserialize, Serialize};

use crate::InferError;

/// Numeric precision of weights and of the values between layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Precision {
    /// 32-bit floating point, as in training.
    #[default]
    F32,
    /// bfloat16, the upper 16 bits of f32.
    Bf16,
    /// 8-bit integers, quantised with calibrated ranges: see [`CalibrationRanges`].
    Int8,
}

impl Precision {
    /// All precisions, the most exact first.
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
    type Err = InferError;

    fn from_str(word: &str) -> Result<Self, InferError> {
        let named = Self::ALL.into_iter().find(|precision| precision.to_string() == word);
        named.ok_or_else(|| InferError::UnknownPrecision(word.to_owned()))
    }
}

/// Calibration of int8: the observed minimum and maximum of each node's values, from which scale
/// and zero point follow (a min-max observer, as PyTorch's `MinMaxObserver`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CalibrationRanges {
    nodes: Vec<NodeRange>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct NodeRange {
    name: String,
    /// None where the node is fused into another, or was not observed yet.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    range: Option<[f32; 2]>,
}

impl CalibrationRanges {
    /// Empty ranges of a graph.
    pub fn new(graph: &Graph) -> Self {
        let unobserved = |name: &String| NodeRange { name: name.clone(), range: None };
        Self { nodes: graph.nodes.iter().map(|node| unobserved(&node.name)).collect() }
    }

    /// Extends the range of a node by observed values.
    pub(crate) fn observe(&mut self, node: usize, [low, high]: [f32; 2]) {
        let range = &mut self.nodes[node].range;
        let [min, max] = range.unwrap_or([low, high]);
        *range = Some([min.min(low), max.max(high)]);
    }

    /// The first layer with values that were not finite: neither int8 nor a file of ranges can
    /// represent them.
    pub fn first_not_finite(&self) -> Option<&str> {
        let is_finite = |range: [f32; 2]| range.iter().all(|end| end.is_finite());
        let mut nodes = self.nodes.iter();
        nodes.find(|node| !node.range.is_none_or(is_finite)).map(|node| node.name.as_str())
    }

    /// Quantised type of a node's values.
    ///
    /// # Errors
    /// [`InferError::NotCalibrated`] if the node was not observed, or its values are not finite.
    pub(crate) fn low_precision_type(&self, node: usize) -> Result<LowPrecisionType, InferError> {
        let NodeRange { name, range } = &self.nodes[node];
        let is_usable = |[low, high]: &[f32; 2]| low.is_finite() && high.is_finite();
        let [low, high] = range
            .filter(is_usable)
            .ok_or_else(|| InferError::NotCalibrated { layer: name.clone() })?;
        Ok(LowPrecisionType::Uint8(QuantizationParams::from_range(low, high)))
    }

    /// Compares the names of the nodes.
    ///
    /// # Errors
    /// [`InferError::NotCalibrated`] if the ranges are those of another graph.
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
