//! The loss of a network of joints on a batch.

use burn::tensor::Tensor;
use evpose_nn::{JointLoss, JointNet, JointTargets};

use crate::metric::{BatchValues, LOSS, LoggedValue};
use crate::training::TrainingLoss;

/// Inputs and the joints at the ends of their windows.
#[derive(Debug, Clone)]
pub struct JointBatch {
    /// Representations, `[batch, 2, height, width]`.
    pub inputs: Tensor<4>,
    /// The joints in them.
    pub joints: JointTargets,
}

/// The values that trainings of joints log for each batch: the loss, the mean absolute error of the depth of a joint in
/// lengths of the palm, the divergence of heatmaps and the cross-entropy of the presence.
pub const JOINT_VALUES: [LoggedValue; 4] = [
    LoggedValue::error(LOSS, ""),
    LoggedValue::error("depth", "palms"),
    LoggedValue::error("divergence", "nat"),
    LoggedValue::error("presence", "nat"),
];

impl TrainingLoss<JointNet> for JointLoss {
    type Batch = JointBatch;

    fn inputs(batch: &mut JointBatch) -> &mut Tensor<4> {
        &mut batch.inputs
    }

    fn measure(&self, network: &JointNet, batch: JointBatch) -> (Tensor<1>, BatchValues) {
        let [samples, ..] = batch.inputs.dims();
        let parts = self.forward(network.forward(batch.inputs), &batch.joints);
        let read = |tensor: &Tensor<1>| f64::from(tensor.clone().into_scalar::<f32>());
        let values = vec![
            read(&parts.total),
            read(&parts.depth),
            read(&parts.divergence),
            read(&parts.presence),
        ];
        (parts.total, BatchValues { samples, values })
    }
}
