//! The targets of many samples.

use burn::tensor::{Device, Tensor, TensorData};
use evpose_nn::BodyTargets;

use super::BodyTargetSlices;

/// Memory for the targets of a batch, filled sample by sample and then made into tensors.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyBatch {
    samples: usize,
    joints: usize,
    side: usize,
    heatmaps: Vec<f32>,
    centers: Vec<f32>,
    center_cells: Vec<i32>,
    joint_cells: Vec<i32>,
    regs: Vec<[f32; 2]>,
    offsets: Vec<[f32; 2]>,
    known: Vec<f32>,
}

impl BodyBatch {
    /// An empty batch of `samples` samples with `joints` joints and maps of `side` x `side`.
    pub fn new(samples: usize, joints: usize, side: usize) -> Self {
        let (all, cells) = (samples * joints, side * side);
        Self {
            samples,
            joints,
            side,
            heatmaps: vec![0.0; all * cells],
            centers: vec![0.0; samples * cells],
            center_cells: vec![0; samples],
            joint_cells: vec![0; all],
            regs: vec![[0.0; 2]; all],
            offsets: vec![[0.0; 2]; all],
            known: vec![0.0; all],
        }
    }

    /// The memory of each sample: for [`BodyGrid::write`](super::BodyGrid::write), from as many
    /// threads as one likes.
    pub fn samples_mut(&mut self) -> Vec<BodyTargetSlices<'_>> {
        let (joints, cells) = (self.joints, self.side * self.side);
        // Nothing is cut into pieces of nothing.
        let (of_joints, of_cells) = (joints.max(1), cells.max(1));
        let mut heatmaps = self.heatmaps.chunks_exact_mut((joints * cells).max(1));
        let mut centers = self.centers.chunks_exact_mut(of_cells);
        let mut joint_cells = self.joint_cells.chunks_exact_mut(of_joints);
        let mut regs = self.regs.chunks_exact_mut(of_joints);
        let mut offsets = self.offsets.chunks_exact_mut(of_joints);
        let mut known = self.known.chunks_exact_mut(of_joints);
        let slices = self.center_cells.iter_mut().map(|center_cell| BodyTargetSlices {
            heatmaps: heatmaps.next().unwrap_or_default(),
            centers: centers.next().unwrap_or_default(),
            center_cell,
            joint_cells: joint_cells.next().unwrap_or_default(),
            regs: regs.next().unwrap_or_default(),
            offsets: offsets.next().unwrap_or_default(),
            known: known.next().unwrap_or_default(),
        });
        slices.collect()
    }

    /// The batch as tensors, for the loss.
    pub fn into_tensors(self, device: &Device) -> BodyTargets {
        let Self { samples, joints, side, .. } = self;
        let pairs = |pairs: Vec<[f32; 2]>| {
            Tensor::from_data(TensorData::new(pairs.into_flattened(), [samples, joints, 2]), device)
        };
        let maps = |values: Vec<f32>, channels: usize| {
            Tensor::from_data(TensorData::new(values, [samples, channels, side, side]), device)
        };
        let joint_cells = TensorData::new(self.joint_cells, [samples, joints]);
        BodyTargets {
            heatmaps: maps(self.heatmaps, joints),
            centers: maps(self.centers, 1),
            center_cells: Tensor::from_data(TensorData::new(self.center_cells, [samples]), device),
            joint_cells: Tensor::from_data(joint_cells, device),
            regs: pairs(self.regs),
            offsets: pairs(self.offsets),
            known: Tensor::from_data(TensorData::new(self.known, [samples, joints]), device),
        }
    }
}
