//! The loss of the network of joints: how unlike a Gaussian the heatmaps are, how wrong the depths, and whether there
//! is a hand.

use burn::tensor::activation::log_softmax;
use burn::tensor::{Device, Tensor, TensorData};
use serde::{Deserialize, Serialize};

use crate::joint_net::JointMaps;

/// Keeps logarithms finite where a target is zero, at no cost where it is not.
const SMALLEST: f32 = 1e-24;

/// The weights of the parts of the loss.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JointLossConfig {
    /// Of the depths, a length of the palm.
    pub depth: f32,
    /// Of the divergence, a nat.
    pub divergence: f32,
    /// Of the presence, a nat.
    pub presence: f32,
    /// Standard deviation of target heatmaps, in cells.
    pub sigma_cells: f32,
}

impl Default for JointLossConfig {
    /// A nat is as far as a heatmap is from one that is 2.7 times as wide in area, or half a palm in depth.
    fn default() -> Self {
        Self { depth: 2.0, divergence: 1.0, presence: 0.3, sigma_cells: 1.0 }
    }
}

impl JointLossConfig {
    /// Whether it is the default.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Whether it makes sense: weights of at least 0 and a deviation above 0, all finite.
    pub fn is_valid(&self) -> bool {
        let weights = [self.depth, self.divergence, self.presence];
        weights.iter().all(|weight| weight.is_finite() && *weight >= 0.0)
            && self.sigma_cells.is_finite()
            && self.sigma_cells > 0.0
    }
}

/// The target joints of a batch.
#[derive(Debug, Clone)]
pub struct JointTargets {
    /// Column and row of joints in cells, 0 the middle of the first: `[batch, joints, 2]`.
    pub positions: Tensor<3>,
    /// Depth behind the wrist in lengths of the palm: `[batch, joints]`.
    pub depths: Tensor<2>,
    /// 1 for joints inside of the image, 0 for others: `[batch, joints]`.
    pub inside: Tensor<2>,
    /// 1 for images with a hand, 0 without: `[batch, 1]`.
    pub presence: Tensor<2>,
    /// 1 where the presence is certain, 0 for hands of which little is in the image: `[batch, 1]`.
    pub is_certain: Tensor<2>,
}

/// A [`JointLoss`] and its parts, each of shape `[1]` and before its weight.
#[derive(Debug, Clone)]
pub struct JointLossParts {
    /// The weighted sum, which training minimises.
    pub total: Tensor<1>,
    /// Mean absolute error of the depth, in lengths of the palm.
    pub depth: Tensor<1>,
    /// Mean divergence of the heatmaps from their targets, in nats.
    pub divergence: Tensor<1>,
    /// Mean cross-entropy of the presence, in nats.
    pub presence: Tensor<1>,
}

/// The loss of the network of joints.
///
/// # Model
/// With `p` the softmax of a joint's heatmap over the cells, what counts is the Kullback-Leibler divergence of `p` from
/// a Gaussian about the joint, or, of joints outside of the image, from a flat heatmap, which says that they are not
/// seen. So `p` is the likelihood of each place: where a finger may be straight or bent, it has two peaks, and its mean is
/// neither.
/// The depth is the mean of the depth map under the Gaussian, and counts by its absolute error. The presence counts by its
/// cross-entropy.
///
/// # Source
/// Depth maps: Iqbal et al.: *Hand Pose Estimation via Latent 2.5D Heatmap Regression*, ECCV 2018. The divergence after
/// Nibali et al.: *Numerical Coordinate Regression with Convolutional Neural Networks*, 2018.
#[derive(Debug, Clone, Copy, Default)]
pub struct JointLoss {
    config: JointLossConfig,
}

impl JointLoss {
    /// The loss with these weights.
    pub fn new(config: JointLossConfig) -> Self {
        Self { config }
    }

    /// # Shapes
    /// - maps: as of [`JointNet::forward`](crate::JointNet::forward)
    /// - targets: as of [`JointTargets`], of the same batch and joints
    ///
    /// # Panics
    /// If shapes differ.
    pub fn forward(&self, maps: JointMaps, targets: &JointTargets) -> JointLossParts {
        let [_, _, rows, columns] = maps.heatmaps.dims();
        let cells = |maps: Tensor<4>| maps.flatten::<3>(2, 3);
        let log = log_softmax(cells(maps.heatmaps), 2);
        // At least one, so that a batch without a joint has a loss of zero, not NaN.
        let inside = targets.inside.clone().sum().clamp_min(1.0);
        let of_inside =
            |errors: Tensor<2>| (errors * targets.inside.clone()).sum() / inside.clone();

        let target = target_heatmaps(targets, rows, columns, self.config.sigma_cells);
        let difference = (target.clone() + SMALLEST).log() - log;
        let divergence: Tensor<2> = (target.clone() * difference).sum_dim(2).squeeze_dim(2);
        let divergence = divergence.mean();
        let depth: Tensor<2> = (target * cells(maps.depths)).sum_dim(2).squeeze_dim(2);
        let depth = of_inside((depth - targets.depths.clone()).abs());

        let presence = presence_loss(maps.presence, targets);
        let JointLossConfig { depth: d, divergence: k, presence: c, .. } = self.config;
        let total = depth.clone() * d + divergence.clone() * k + presence.clone() * c;
        JointLossParts { total, depth, divergence, presence }
    }
}

/// Gaussians of sum 1 about joints inside of the image, flat heatmaps of the others.
///
/// # Shapes
/// - output: `[batch, joints, rows * columns]`
fn target_heatmaps(
    targets: &JointTargets,
    rows: usize,
    columns: usize,
    sigma_cells: f32,
) -> Tensor<3> {
    let device = targets.positions.device();
    let along = |axis: usize, cells: usize| -> Tensor<3> {
        let distance = cells_of(cells, &device) - targets.positions.clone().narrow(2, axis, 1);
        (distance.square() * (-0.5 / (sigma_cells * sigma_cells))).exp()
    };
    // A Gaussian in two dimensions is the product of two in one, with far fewer exponentials.
    let values: Tensor<4> =
        along(1, rows).unsqueeze_dim::<4>(3) * along(0, columns).unsqueeze_dim::<4>(2);
    let values = values.flatten::<3>(2, 3);
    let sum = values.clone().sum_dim(2) + SMALLEST;
    let inside: Tensor<3> = targets.inside.clone().unsqueeze_dim(2);
    let flat = (inside.clone() * -1.0 + 1.0) / (rows * columns) as f32;
    values / sum * inside + flat
}

/// 0, 1, … of shape `[1, 1, cells]`.
fn cells_of(cells: usize, device: &Device) -> Tensor<3> {
    let values: Vec<f32> = (0..cells).map(|cell| cell as f32).collect();
    Tensor::from_data(TensorData::new(values, [1, 1, cells]), device)
}

/// The cross-entropy of logits where the presence is certain.
fn presence_loss(logits: Tensor<2>, targets: &JointTargets) -> Tensor<1> {
    // max(z, 0) - z y + ln(1 + exp(-|z|)): no exponential overflows.
    let soft = (logits.clone().abs() * -1.0).exp().log1p();
    let entropy = logits.clone().clamp_min(0.0) - logits * targets.presence.clone() + soft;
    let certain = targets.is_certain.clone();
    (entropy * certain.clone()).sum() / certain.sum().clamp_min(1.0)
}

#[cfg(test)]
mod tests;
