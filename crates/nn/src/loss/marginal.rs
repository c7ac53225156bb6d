//! The loss of LiftMono-HPE: distances of joints in three dimensions, and how unlike a Gaussian the
//! heatmaps are.

use burn::tensor::{Device, Tensor};

use crate::lift_mono::{MarginalMaps, cell_centres};

/// Keeps logarithms finite where a heatmap is zero. As published.
const SMALLEST: f32 = 1e-24;
/// Keeps the gradient of a root finite where the target is met to the bit; lost in rounding
/// elsewhere.
const SMALLEST_SQUARE: f32 = 1e-12;

/// The target positions of a batch.
#[derive(Debug, Clone)]
pub struct MarginalTargets {
    /// x, y and z of joints, -1 to 1 from one border of the maps to the other: `[batch, joints, 3]`.
    pub positions: Tensor<3>,
    /// 1 for joints that are known, 0 for others: `[batch, joints]`.
    pub known: Tensor<2>,
}

/// A loss and its parts, each of shape `[1]`.
#[derive(Debug, Clone)]
pub struct MarginalLossParts {
    /// The sum of the parts, which training minimises.
    pub total: Tensor<1>,
    /// The distance of joints from their targets, in half widths of the maps.
    pub distance: Tensor<1>,
    /// The divergence of heatmaps from Gaussians about the targets, over all three planes.
    pub divergence: Tensor<1>,
}

/// The loss of the heatmaps of all stages.
///
/// # Model
/// The mean over stages and known joints of the distance of the position that the maps say, plus
/// for each plane the Jensen-Shannon divergence of the map from a Gaussian of `sigma_cells` about
/// the target.
///
/// # Shapes
/// - stages: as of [`LiftMono::forward`](crate::LiftMono::forward)
///
/// # Source
/// Scarpellini et al.: *Lifting Monocular Events to 3D Human Poses*, CVPRW 2021, and its published
/// code, which divides by 3 however many stages there are.
pub fn marginal_loss(
    stages: &[MarginalMaps],
    targets: &MarginalTargets,
    sigma_cells: f32,
) -> MarginalLossParts {
    // At least one, so that a batch without labels has a loss of zero, not NaN.
    let known_joints = targets.known.clone().sum().clamp_min(1.0);
    let mean = |errors: Tensor<2>| (errors * targets.known.clone()).sum() / known_joints.clone();
    let device = targets.positions.device();
    let mut distance = Tensor::<1>::zeros([1], &device);
    let mut divergence = Tensor::<1>::zeros([1], &device);
    for maps in stages {
        let error = maps.positions() - targets.positions.clone();
        let squares: Tensor<2> = error.square().sum_dim(2).squeeze_dim(2);
        distance = distance + mean((squares + SMALLEST_SQUARE).sqrt());
        let axis = |index: usize| targets.positions.clone().narrow(2, index, 1);
        // Columns and rows of the three planes.
        for (map, [across, down]) in [(&maps.xy, [0, 1]), (&maps.zy, [2, 1]), (&maps.xz, [0, 2])] {
            let target = gaussian(map.dims(), [axis(across), axis(down)], sigma_cells, &device);
            divergence = divergence + mean(jensen_shannon(map.clone(), target));
        }
    }
    let count = stages.len().max(1) as f32;
    let (distance, divergence) = (distance / count, divergence / count);
    MarginalLossParts { total: distance.clone() + divergence.clone(), distance, divergence }
}

/// Gaussians of sum 1 about `across`, the column, and `down`, the row, -1 to 1.
///
/// # Shapes
/// - across, down: `[batch, joints, 1]`, output: `shape`, `[batch, joints, height, width]`
fn gaussian(
    shape: [usize; 4],
    [across, down]: [Tensor<3>; 2],
    sigma_cells: f32,
    device: &Device,
) -> Tensor<4> {
    let [_, _, height, width] = shape;
    let along = |cells: usize, mean: Tensor<3>| -> Tensor<3> {
        let deviation = 2.0 * sigma_cells / cells as f32;
        let distance = cell_centres(cells, device) - mean;
        (distance.square() * (-0.5 / (deviation * deviation))).exp()
    };
    // A Gaussian in two dimensions is the product of two in one, with far fewer exponentials.
    let values: Tensor<4> =
        along(height, down).unsqueeze_dim::<4>(3) * along(width, across).unsqueeze_dim::<4>(2);
    let sum = values.clone().sum_dim(3).sum_dim(2) + SMALLEST;
    values / sum
}

/// The Jensen-Shannon divergence of two distributions over cells, in nats.
///
/// # Shapes
/// - p, q: `[batch, joints, height, width]`, output: `[batch, joints]`
fn jensen_shannon(p: Tensor<4>, q: Tensor<4>) -> Tensor<2> {
    let middle = (p.clone() + q.clone()) * 0.5;
    let log = |x: Tensor<4>| (x + SMALLEST).log();
    let log_middle = log(middle);
    let kullback = |p: Tensor<4>| p.clone() * (log(p) - log_middle.clone());
    let values = (kullback(p) + kullback(q)) * 0.5;
    values.sum_dim(3).sum_dim(2).flatten::<3>(2, 3).squeeze_dim(2)
}

#[cfg(test)]
mod tests {
    use burn::tensor::TensorData;

    use super::*;

    fn single(row: usize, column: usize) -> Tensor<4> {
        let mut values = vec![0.0f32; 64];
        values[row * 8 + column] = 1.0;
        Tensor::from_data(TensorData::new(values, [1, 1, 8, 8]), &Device::flex())
    }

    fn value(tensor: Tensor<1>) -> f32 {
        tensor.into_scalar()
    }

    #[test]
    fn distributions_diverge_by_zero_to_the_logarithm_of_two() {
        let values = |tensor: Tensor<2>| -> Vec<f32> { tensor.into_data().iter().collect() };
        assert_eq!(values(jensen_shannon(single(2, 3), single(2, 3))), [0.0]);
        let apart = values(jensen_shannon(single(2, 3), single(5, 1)))[0];
        assert!((apart - 2f32.ln()).abs() < 1e-6, "{apart}");
    }

    #[test]
    fn joints_that_are_not_known_and_stages_that_repeat_do_not_count() {
        let device = Device::flex();
        let double = |map: Tensor<4>| Tensor::cat(vec![map.clone(), map], 1);
        let maps = MarginalMaps {
            xy: double(single(2, 3)),
            zy: double(single(2, 4)),
            xz: double(single(4, 3)),
        };
        let loss = |second: [f32; 3], known: [f32; 2], stages: usize| {
            let first = [-0.125, -0.375, 0.125];
            let positions = TensorData::new([first, second].concat(), [1, 2, 3]);
            let targets = MarginalTargets {
                positions: Tensor::from_data(positions, &device),
                known: Tensor::from_data(TensorData::new(known.to_vec(), [1, 2]), &device),
            };
            let parts = marginal_loss(&vec![maps.clone(); stages], &targets, 1.0);
            [parts.total, parts.distance, parts.divergence].map(value)
        };
        let alone = loss([0.5, 0.5, 0.5], [1.0, 0.0], 1);
        assert!(alone[1] < 1e-5, "met: {alone:?}");
        assert!((alone[0] - alone[1] - alone[2]).abs() < 1e-6, "{alone:?}");
        assert_eq!(loss([-0.5, 0.1, 0.2], [1.0, 0.0], 1), alone);
        let again = loss([0.5, 0.5, 0.5], [1.0, 0.0], 3);
        assert!(again.iter().zip(alone).all(|(a, b)| (a - b).abs() < 1e-6), "{again:?}");
        let both = loss([0.475, -0.375, 0.125], [1.0, 1.0], 1);
        assert!((both[1] - 0.3).abs() < 1e-5, "half of 0.6: {both:?}");
    }
}
