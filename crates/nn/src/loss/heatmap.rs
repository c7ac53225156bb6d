//! The loss of DHP19's network: the mean squared error of heatmaps.

use burn::tensor::Tensor;

/// Target heatmaps of a batch, each the product of a column of rows and a row of columns: a blurred
/// point is separable.
#[derive(Debug, Clone)]
pub struct HeatmapTargets {
    /// Along rows, at most 1; all zero for joints that are not in view: `[batch, joints, height]`.
    pub rows: Tensor<3>,
    /// Along columns, likewise: `[batch, joints, width]`.
    pub columns: Tensor<3>,
}

impl HeatmapTargets {
    /// The heatmaps themselves.
    ///
    /// # Shapes
    /// - output: `[batch, joints, height, width]`
    pub fn heatmaps(&self) -> Tensor<4> {
        self.rows.clone().unsqueeze_dim::<4>(3) * self.columns.clone().unsqueeze_dim::<4>(2)
    }
}

/// The mean of squared errors over all cells, joints and samples, of shape `[1]`.
///
/// # Shapes
/// - heatmaps: `[batch, joints, height, width]`, as those of the targets
///
/// # Source
/// Calabrese et al.: *DHP19*, CVPRW 2019, and its published code.
pub fn heatmap_loss(heatmaps: Tensor<4>, targets: &HeatmapTargets) -> Tensor<1> {
    (heatmaps - targets.heatmaps()).square().mean()
}

#[cfg(test)]
mod tests {
    use burn::tensor::{Device, TensorData};

    use super::*;

    #[test]
    fn squares_are_averaged_over_all_cells_and_a_joint_out_of_view_is_black() {
        let device = Device::flex();
        let tensor = |values: Vec<f32>, length: usize| {
            Tensor::<3>::from_data(TensorData::new(values, [1, 2, length]), &device)
        };
        let targets = HeatmapTargets {
            rows: tensor(vec![1.0, 0.5, 0.0, 0.0], 2),
            columns: tensor(vec![0.25, 1.0, 0.5, 0.0, 0.0, 0.0], 3),
        };
        let values: Vec<f32> = targets.heatmaps().into_data().iter().collect();
        let first = [0.25, 1.0, 0.5, 0.125, 0.5, 0.25];
        assert_eq!((&values[..6], &values[6..]), (&first[..], &[0.0; 6][..]));
        let loss: f32 = heatmap_loss(Tensor::zeros([1, 2, 2, 3], &device), &targets).into_scalar();
        let want = first.iter().map(|v| v * v).sum::<f32>() / 12.0;
        assert!((loss - want).abs() < 1e-7, "{loss} {want}");
    }
}
