//! Windows of hands with their poses as batches.

use std::ops::Range;
use std::sync::Arc;

use burn::data::dataset::DatasetError;
use burn::tensor::{Device, Tensor, TensorData};
use rayon::prelude::*;

use crate::batch_loader::BatchSource;
use crate::hand::dataset::{HandDataset, Sample, SampleError};
use crate::hand::loss::HandBatch;
use crate::passes::Passes;

/// A data set that becomes batches.
#[derive(Debug, Clone)]
pub(crate) struct HandBatches(pub(crate) Arc<HandDataset>);

impl BatchSource for HandBatches {
    type Host = Vec<Sample>;
    type Item = HandBatch;

    fn host_batch(
        &self,
        passes: &Passes,
        positions: Range<u64>,
    ) -> Result<Vec<Sample>, DatasetError> {
        let sample = |position| match passes {
            Passes::Training { .. } => self.0.training_sample(position),
            Passes::Validation { samples } => {
                // Spread evenly: the first samples would all be of a few sequences.
                self.0.plain_sample(position * self.0.len() / samples)
            }
        };
        let samples: Result<_, SampleError> = positions.into_par_iter().map(sample).collect();
        samples.map_err(DatasetError::new)
    }

    fn item(&self, samples: Vec<Sample>, device: &Device) -> HandBatch {
        let (count, rotation) = (samples.len(), self.0.rotation());
        let mut inputs = Vec::with_capacity(samples.iter().map(|s| s.input.len()).sum());
        let mut poses = Vec::with_capacity(count * rotation.outputs());
        for sample in &samples {
            inputs.extend_from_slice(&sample.input);
            rotation.push_targets(&sample.pose, &mut poses);
        }
        let (height, width) = self.0.sample_size();
        let inputs = TensorData::new(inputs, [count, 2, height, width]);
        let poses = TensorData::new(poses, [count, rotation.outputs()]);
        HandBatch {
            inputs: Tensor::from_data(inputs, device),
            poses: Tensor::from_data(poses, device),
        }
    }
}
