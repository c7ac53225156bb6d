//! Heatmaps on three planes, and the positions that they say.

use burn::tensor::{Device, Tensor, TensorData};

/// Heatmaps of joints on three orthogonal planes, each of sum 1: x grows to the right, y down, z
/// away from the camera.
///
/// # Shapes
/// All `[batch, joints, height, width]`.
#[derive(Debug, Clone)]
pub struct MarginalMaps {
    /// Columns are x, rows are y.
    pub xy: Tensor<4>,
    /// Columns are z, rows are y.
    pub zy: Tensor<4>,
    /// Columns are x, rows are z.
    pub xz: Tensor<4>,
}

impl MarginalMaps {
    /// In the order of the fields.
    pub fn into_array(self) -> [Tensor<4>; 3] {
        [self.xy, self.zy, self.xz]
    }

    /// In the order of the fields.
    pub fn from_array([xy, zy, xz]: [Tensor<4>; 3]) -> Self {
        Self { xy, zy, xz }
    }

    /// The positions of joints, -1 to 1 from one border of the maps to the other: x and y are the
    /// expected values on `xy`, z is the mean of those on the other two.
    ///
    /// # Shapes
    /// - output: `[batch, joints, 3]`
    ///
    /// # Source
    /// Nibali et al.: *Numerical Coordinate Regression with Convolutional Neural Networks*, 2018.
    pub fn positions(&self) -> Tensor<3> {
        let [xy, zy, xz] = [&self.xy, &self.zy, &self.xz].map(expectation);
        let z = (zy.narrow(2, 0, 1) + xz.narrow(2, 1, 1)) * 0.5;
        Tensor::cat(vec![xy, z], 2)
    }

    /// How sure the network is of joints, 0 to 1: the peak of `xy` relative to that of a Gaussian
    /// of one cell, which is the target in training.
    ///
    /// # Shapes
    /// - output: `[batch, joints]`
    pub fn scores(&self) -> Tensor<2> {
        let [batch, joints, height, width] = self.xy.dims();
        let peak = self.xy.clone().reshape([batch, joints, height * width]).max_dim(2);
        (peak.reshape([batch, joints]) * std::f32::consts::TAU).clamp_max(1.0)
    }
}

/// Expected column and row, -1 to 1.
///
/// # Shapes
/// - map: `[batch, joints, height, width]`, output: `[batch, joints, 2]`
fn expectation(map: &Tensor<4>) -> Tensor<3> {
    let [batch, joints, height, width] = map.dims();
    let device = map.device();
    let along = |dim: usize, cells: usize| {
        // A marginal first: each coordinate then needs the products of one line, not of all cells.
        let marginal: Tensor<3> = map.clone().sum_dim(dim).reshape([batch, joints, cells]);
        (marginal * cell_centres(cells, &device)).sum_dim(2)
    };
    Tensor::cat(vec![along(2, width), along(3, height)], 2)
}

/// The centres of `cells` equal cells between -1 and 1.
///
/// # Shapes
/// - output: `[1, 1, cells]`
pub(crate) fn cell_centres(cells: usize, device: &Device) -> Tensor<3> {
    let centre = |k: usize| (2.0 * k as f32 + 1.0) / cells as f32 - 1.0;
    let centres: Vec<f32> = (0..cells).map(centre).collect();
    Tensor::from_data(TensorData::new(centres, [1, 1, cells]), device)
}

/// The softmax over the cells of each joint.
///
/// # Shapes
/// - scores, output: `[batch, joints, height, width]`
pub(super) fn softmax(scores: Tensor<4>) -> Tensor<4> {
    let shape = scores.dims();
    let [batch, joints, height, width] = shape;
    let flat: Tensor<3> = scores.reshape([batch, joints, height * width]);
    burn::tensor::activation::softmax(flat, 2).reshape(shape)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_cell_is_read_at_its_middle_and_z_from_both_planes() {
        let device = Device::flex();
        let at = |row: usize, column: usize| {
            let mut values = vec![0.0f32; 4 * 8];
            values[row * 8 + column] = 1.0;
            Tensor::<4>::from_data(TensorData::new(values, [1, 1, 4, 8]), &device)
        };
        // x 6, y 1; z is column 2 on one plane and row 2 on the other.
        let maps = MarginalMaps { xy: at(1, 6), zy: at(1, 2), xz: at(2, 6) };
        let values: Vec<f32> = maps.positions().into_data().iter().collect();
        let z = 0.5 * ((5.0 / 8.0 - 1.0) + (5.0 / 4.0 - 1.0));
        let want = [13.0 / 8.0 - 1.0, 3.0 / 4.0 - 1.0, z];
        assert!(values.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-6), "{values:?}");
        let score: Vec<f32> = maps.scores().into_data().iter().collect();
        assert_eq!(score, [1.0]);
    }

    #[test]
    fn a_softmax_sums_to_one_over_each_joint() {
        let values: Vec<f32> = (0..2 * 3 * 4 * 5).map(|k| (k % 11) as f32).collect();
        let scores = Tensor::<4>::from_data(TensorData::new(values, [2, 3, 4, 5]), &Device::flex());
        let sums: Vec<f32> = softmax(scores).sum_dim(3).sum_dim(2).into_data().iter().collect();
        assert!(sums.len() == 6 && sums.iter().all(|sum| (sum - 1.0).abs() < 1e-6), "{sums:?}");
    }
}
