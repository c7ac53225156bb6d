//! The loss of MoveEnet: squared errors of heatmaps and of limbs on them, and absolute errors of
//! the regressions at single cells.

use burn::tensor::{Int, Tensor, TensorData};
use evpose_pose::body::{BodyMaps, LIMBS};
use serde::{Deserialize, Serialize};

/// Weight of an error where the target is 1, relative to where it is 0, less one. As published.
const PEAK_WEIGHT: f32 = 8.0;
/// Added to counts of samples: keeps the mean finite where none has the joint. As published.
const NO_JOINT: f32 = 1e-4;
/// The published bones, by joints of a network of seven joints that came before.
const PARITY_BONES: [[usize; 2]; 7] = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 6], [2, 4]];
/// Square root of 64, the published batch: what dividing by the batch outside of a root leaves of
/// its mean.
const PUBLISHED_BATCH_ROOT: f32 = 8.0;
/// Keeps the gradient of a root finite where the target is met to the bit; lost in rounding
/// elsewhere.
const SMALLEST_SQUARE: f32 = 1e-12;

/// The weights of the parts of the loss.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyLossConfig {
    /// Of the heatmaps of joints.
    pub heatmap: f32,
    /// Of limbs on the heatmaps.
    pub bone: f32,
    /// Of the heatmap of body centres.
    pub center: f32,
    /// Of the positions of joints relative to the body centre.
    pub regs: f32,
    /// Of the positions of joints within their cells.
    pub offsets: f32,
    /// Bones as published, see [`BodyLoss`].
    pub parity: bool,
}

impl Default for BodyLossConfig {
    /// The published weights.
    fn default() -> Self {
        Self { heatmap: 1.0, bone: 20.0, center: 1.0, regs: 3.0, offsets: 1.0, parity: false }
    }
}

/// The loss of MoveEnet.
///
/// # Model
/// Of `N` samples, `p` the prediction and `t` the target:
/// - heatmaps and centres: `sum (p - t)² (8 t + 1) / N / channels`;
/// - bones: for each pair of joints `a`, `b`, the norm over cells of `(p_a - p_b) - (t_a - t_b)`,
///   their mean over pairs and samples, divided by 8;
/// - regressions at the cell of the body centre and offsets at the cells of joints: for each
///   coordinate of each joint the mean of `|p - t|` over samples that have the joint; their sum
///   over the joints' coordinates, divided by the number of joints.
///
/// With `parity`, bones are as published: seven pairs from the skeleton of another network, and one
/// norm over cells and samples together, divided by `N` outside of the root, which falls with the
/// root of the batch. By default they are the [`LIMBS`] of ours, and no matter how large the batch,
/// they count as the published ones do in a batch of 64.
///
/// # Source
/// Goyal et al.: *MoveEnet*, CVPRW 2023, and its published code.
#[derive(Debug, Clone)]
pub struct BodyLoss {
    config: BodyLossConfig,
    bones: Vec<[usize; 2]>,
}

/// The target maps of a batch. Cells are counted row by row.
#[derive(Debug, Clone)]
pub struct BodyTargets {
    /// Likelihood of each joint in each cell: `[batch, joints, rows, columns]`.
    pub heatmaps: Tensor<4>,
    /// Likelihood of the body centre in each cell: `[batch, 1, rows, columns]`.
    pub centers: Tensor<4>,
    /// The cell at which regressions are read: `[batch]`.
    pub center_cells: Tensor<1, Int>,
    /// The cells at which offsets are read: `[batch, joints]`.
    pub joint_cells: Tensor<2, Int>,
    /// x and y of joints relative to the cell of the centre, in cells: `[batch, joints, 2]`.
    pub regs: Tensor<3>,
    /// x and y of joints in their cells, in cells: `[batch, joints, 2]`.
    pub offsets: Tensor<3>,
    /// 1 for joints that are known, 0 for others: `[batch, joints]`.
    pub known: Tensor<2>,
}

/// A [`BodyLoss`] and its parts, each of shape `[1]` and before its weight.
#[derive(Debug, Clone)]
pub struct BodyLossParts {
    /// The weighted sum, which training minimises.
    pub total: Tensor<1>,
    /// The part of the heatmaps.
    pub heatmap: Tensor<1>,
    /// The part of the limbs.
    pub bone: Tensor<1>,
    /// The part of the body centres.
    pub center: Tensor<1>,
    /// The part of the regressions.
    pub regs: Tensor<1>,
    /// The part of the offsets.
    pub offsets: Tensor<1>,
}

impl BodyLoss {
    /// The loss of networks of the first `joints` of the thirteen joints. Joints beyond them have
    /// no limbs.
    pub fn new(config: BodyLossConfig, joints: usize) -> Self {
        let bones: &[[usize; 2]] = if config.parity { &PARITY_BONES } else { &LIMBS };
        let has = |bone: &&[usize; 2]| bone.iter().all(|&joint| joint < joints);
        Self { config, bones: bones.iter().filter(has).copied().collect() }
    }

    /// # Shapes
    /// - maps: as of [`MoveEnet::forward`](crate::MoveEnet::forward)
    /// - targets: as of [`BodyTargets`], of the same batch, joints, rows and columns
    ///
    /// # Panics
    /// If shapes differ.
    pub fn forward(&self, maps: BodyMaps<Tensor<4>>, targets: BodyTargets) -> BodyLossParts {
        let heatmap = weighted_squares(maps.heatmaps.clone(), targets.heatmaps.clone());
        let bone = self.bone(&(maps.heatmaps - targets.heatmaps));
        let center = weighted_squares(maps.centers, targets.centers);
        let [batch, joints, _] = targets.regs.dims();
        // Regression is compared at the cell of the centre only, offsets at the cells of the
        // joints.
        let at_center = targets.center_cells.reshape([batch, 1, 1]).repeat_dim(1, 2 * joints);
        let at_joints = targets.joint_cells.reshape([batch, joints, 1]).repeat_dim(2, 2);
        let at_joints = at_joints.reshape([batch, 2 * joints, 1]);
        let regs = absolute(read(maps.regs, at_center), targets.regs, targets.known.clone());
        let offsets = absolute(read(maps.offsets, at_joints), targets.offsets, targets.known);
        let total = heatmap.clone() * self.config.heatmap
            + bone.clone() * self.config.bone
            + center.clone() * self.config.center
            + regs.clone() * self.config.regs
            + offsets.clone() * self.config.offsets;
        BodyLossParts { total, heatmap, bone, center, regs, offsets }
    }

    /// # Shapes
    /// - error: `[batch, joints, rows, columns]`
    fn bone(&self, error: &Tensor<4>) -> Tensor<1> {
        let [batch, ..] = error.dims();
        let device = error.device();
        if self.bones.is_empty() {
            return Tensor::zeros([1], &device);
        }
        let ends = [0, 1].map(|end| {
            let joints: Vec<i32> = self.bones.iter().map(|bone| bone[end] as i32).collect();
            Tensor::<1, Int>::from_data(TensorData::from(joints.as_slice()), &device)
        });
        let [a, b] = ends.map(|joints| error.clone().select(1, joints));
        let squares: Tensor<2> = (a - b).square().flatten::<3>(2, 3).sum_dim(2).squeeze_dim(2);
        let norm = |squares: Tensor<2>| (squares + SMALLEST_SQUARE).sqrt().mean();
        // The published loss takes one norm over the whole batch and divides by its size: it
        // depends on the batch. The norm per image is scaled to the same value at the published
        // size.
        if self.config.parity {
            norm(squares.sum_dim(0)) / batch as f32
        } else {
            norm(squares) / PUBLISHED_BATCH_ROOT
        }
    }
}

/// Squared errors, those near peaks counting more, by sample and channel.
fn weighted_squares(prediction: Tensor<4>, target: Tensor<4>) -> Tensor<1> {
    let [batch, channels, ..] = target.dims();
    let weight = target.clone() * PEAK_WEIGHT + 1.0;
    ((prediction - target).square() * weight).sum() / (batch * channels) as f32
}

/// The two channels of each joint, each at its cell.
///
/// # Shapes
/// - maps: `[batch, 2 * joints, rows, columns]`, cells: `[batch, 2 * joints, 1]`
/// - output: `[batch, joints, 2]`
fn read(maps: Tensor<4>, cells: Tensor<3, Int>) -> Tensor<3> {
    let [batch, channels, ..] = maps.dims();
    maps.flatten::<3>(2, 3).gather(2, cells).reshape([batch, channels / 2, 2])
}

/// Absolute errors of joints that are known.
///
/// # Shapes
/// - prediction, target: `[batch, joints, 2]`, known: `[batch, joints]`
fn absolute(prediction: Tensor<3>, target: Tensor<3>, known: Tensor<2>) -> Tensor<1> {
    let [_, joints, _] = target.dims();
    let known: Tensor<3> = known.unsqueeze_dim(2);
    let errors = ((prediction - target).abs() * known.clone()).sum_dim(0);
    (errors / (known.sum_dim(0) + NO_JOINT)).sum() / joints as f32
}

#[cfg(test)]
mod tests;
