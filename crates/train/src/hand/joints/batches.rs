//! Windows of hands with their joints as batches.

use std::ops::Range;
use std::sync::Arc;

use burn::data::dataset::DatasetError;
use burn::tensor::{Device, Tensor, TensorData};
use evpose_nn::JointTargets;
use evpose_pose::EVALUATION_JOINTS;

use super::loss::JointBatch;
use crate::batch_loader::BatchSource;
use crate::hand::batches::HandBatches;
use crate::hand::dataset::{HandDataset, Sample};
use crate::passes::Passes;

/// A data set that becomes batches for a network of joints.
#[derive(Debug, Clone)]
pub(crate) struct JointBatches(pub(crate) Arc<HandDataset>);

impl BatchSource for JointBatches {
    type Host = Vec<Sample>;
    type Item = JointBatch;

    fn host_batch(
        &self,
        passes: &Passes,
        positions: Range<u64>,
    ) -> Result<Vec<Sample>, DatasetError> {
        HandBatches(Arc::clone(&self.0)).host_batch(passes, positions)
    }

    fn item(&self, samples: Vec<Sample>, device: &Device) -> JointBatch {
        let (count, joints) = (samples.len(), EVALUATION_JOINTS.len());
        let mut inputs = Vec::with_capacity(samples.iter().map(|s| s.input.len()).sum());
        let (mut positions, mut depths, mut inside) = (Vec::new(), Vec::new(), Vec::new());
        let (mut presence, mut is_certain) = (Vec::new(), Vec::new());
        for sample in &samples {
            inputs.extend_from_slice(&sample.input);
            let label = sample.joints.as_deref();
            let label = label.unwrap_or_else(|| unreachable!("samples of joints have labels"));
            positions.extend(label.positions.iter().flat_map(|position| position.to_array()));
            depths.extend_from_slice(&label.depths);
            inside.extend(label.inside.map(|is_inside| f32::from(u8::from(is_inside))));
            presence.push(f32::from(u8::from(label.presence == Some(true))));
            is_certain.push(f32::from(u8::from(label.presence.is_some())));
        }
        let (height, width) = self.0.sample_size();
        let inputs = TensorData::new(inputs, [count, 2, height, width]);
        let positions = TensorData::new(positions, [count, joints, 2]);
        let table = |values: Vec<f32>, columns: usize| {
            Tensor::<2>::from_data(TensorData::new(values, [count, columns]), device)
        };
        JointBatch {
            inputs: Tensor::from_data(inputs, device),
            joints: JointTargets {
                positions: Tensor::from_data(positions, device),
                depths: table(depths, joints),
                inside: table(inside, joints),
                presence: table(presence, 1),
                is_certain: table(is_certain, 1),
            },
        }
    }
}
