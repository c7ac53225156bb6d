//! Trainings of networks from planes to a vector of values, on samples in memory.

use std::ops::Range;
use std::sync::Arc;

use burn::data::dataset::DatasetError;
use burn::module::Module;
use burn::tensor::{Device, Tensor, TensorData};

use super::learner::TrainingLoss;
use crate::batch_loader::BatchSource;
use crate::metric::BatchValues;
use crate::order::SampleOrder;
use crate::passes::Passes;

/// A network from planes, `[batch, channels, height, width]`, to vectors, `[batch, values]`.
pub trait PlaneNetwork: Module {
    /// The vectors of a batch of planes.
    fn forward(&self, planes: Tensor<4>) -> Tensor<2>;
}

/// Planes, each with the vector that a perfect network makes of them.
#[derive(Debug, Clone)]
pub struct PlaneSamples {
    shape: [usize; 3],
    samples: Arc<Vec<(Vec<f32>, Vec<f32>)>>,
    order: SampleOrder,
}

impl PlaneSamples {
    /// Samples of planes of the shape `[channels, height, width]`, which `seed` shuffles in training.
    ///
    /// # Panics
    /// If there are none.
    pub fn new(shape: [usize; 3], samples: Vec<(Vec<f32>, Vec<f32>)>, seed: u64) -> Self {
        let order = SampleOrder::new(samples.len() as u64, seed);
        Self { shape, samples: Arc::new(samples), order }
    }
}

/// A batch of [`PlaneSamples`].
#[derive(Debug, Clone)]
pub struct PlaneBatch {
    /// `[batch, channels, height, width]`.
    pub planes: Tensor<4>,
    /// `[batch, values]`.
    pub vectors: Tensor<2>,
}

impl BatchSource for PlaneSamples {
    type Host = Vec<usize>;
    type Item = PlaneBatch;

    fn host_batch(
        &self,
        passes: &Passes,
        positions: Range<u64>,
    ) -> Result<Vec<usize>, DatasetError> {
        let len = self.samples.len();
        Ok(positions.map(|position| passes.sample(&self.order, len, position)).collect())
    }

    fn item(&self, indices: Vec<usize>, device: &Device) -> PlaneBatch {
        let samples = || indices.iter().map(|index| &self.samples[*index]);
        let planes: Vec<f32> = samples().flat_map(|(planes, _)| planes).copied().collect();
        let vectors: Vec<f32> = samples().flat_map(|(_, vector)| vector).copied().collect();
        let (batch, [channels, height, width]) = (indices.len(), self.shape);
        let values = vectors.len() / batch;
        let planes = TensorData::new(planes, [batch, channels, height, width]);
        PlaneBatch {
            planes: Tensor::from_data(planes, device),
            vectors: Tensor::from_data(TensorData::new(vectors, [batch, values]), device),
        }
    }
}

/// The mean square error of the vectors. Its root is logged in another unit, `scale` times smaller.
#[derive(Debug, Clone)]
pub struct MeanSquareError {
    /// Units of the logged error in one of the vectors' units.
    pub scale: f64,
}

impl<N: PlaneNetwork> TrainingLoss<N> for MeanSquareError {
    type Batch = PlaneBatch;

    fn inputs(batch: &mut PlaneBatch) -> &mut Tensor<4> {
        &mut batch.planes
    }

    fn measure(&self, network: &N, batch: PlaneBatch) -> (Tensor<1>, BatchValues) {
        let [samples, _] = batch.vectors.dims();
        let loss = (network.forward(batch.planes) - batch.vectors).powi_scalar(2).mean();
        let value = f64::from(loss.clone().into_scalar::<f32>());
        (loss, BatchValues { samples, values: vec![value, self.scale * value.sqrt()] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Its output is the mean of each plane.
    #[derive(Module, Debug)]
    struct Means;

    impl PlaneNetwork for Means {
        fn forward(&self, planes: Tensor<4>) -> Tensor<2> {
            planes.flatten::<3>(2, 3).mean_dim(2).squeeze_dim(2)
        }
    }

    #[test]
    fn batches_hold_their_samples_and_the_error_is_that_of_their_vectors() {
        let sample = |value: f32| (vec![value, value + 1.0, 0.0, 0.0], vec![value + 0.5, 2.0]);
        let samples = PlaneSamples::new([2, 1, 2], (0..5).map(|k| sample(k as f32)).collect(), 7);
        let validation = Passes::Validation { samples: 5 };
        assert_eq!(samples.host_batch(&validation, 1..3).ok(), Some(vec![1, 2]));
        let batch = samples.item(vec![3, 0], &Device::flex());
        let planes: Vec<f32> = batch.planes.clone().into_data().iter().collect();
        assert_eq!(planes, [3.0, 4.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
        // The first value is met, the second is 0 for 2: half of its square.
        let (_, measured) = MeanSquareError { scale: 10.0 }.measure(&Means, batch);
        assert_eq!(measured.samples, 2);
        assert_eq!(measured.values, [2.0, 10.0 * 2f64.sqrt()]);
    }
}
