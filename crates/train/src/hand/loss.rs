//! The hand network's loss on a batch.

use burn::tensor::Tensor;
use evpose_nn::{HandLoss, HandRegressor};

use crate::metric::{BatchValues, LOSS, LoggedValue};
use crate::training::TrainingLoss;

/// Inputs and the poses at the ends of their windows.
#[derive(Debug, Clone)]
pub struct HandBatch {
    /// Representations, `[batch, 2, height, width]`.
    pub inputs: Tensor<4>,
    /// The outputs of a perfect network, `[batch, 12]` or `[batch, 15]`.
    pub poses: Tensor<2>,
}

/// The values that trainings of hands log for each batch: the published loss L (not its logarithm), and
/// root mean square errors of the six articulation coefficients, of the wrist position and of the
/// axis-angle vector.
pub const HAND_VALUES: [LoggedValue; 4] = [
    LoggedValue::error(LOSS, ""),
    LoggedValue::error("articulation", ""),
    LoggedValue::error("translation", "mm"),
    LoggedValue::error("rotation", "deg"),
];

impl TrainingLoss<HandRegressor> for HandLoss {
    type Batch = HandBatch;

    fn inputs(batch: &mut HandBatch) -> &mut Tensor<4> {
        &mut batch.inputs
    }

    fn measure(&self, network: &HandRegressor, batch: HandBatch) -> (Tensor<1>, BatchValues) {
        let [samples, ..] = batch.inputs.dims();
        let parts = self.forward(network.forward(batch.inputs), batch.poses);
        let read = |tensor: &Tensor<1>| f64::from(tensor.clone().into_scalar::<f32>());
        // The loss means over components, of which three make a length.
        let rms = |mean_square: f64, components: f64| (components * mean_square).sqrt();
        let values = vec![
            read(&parts.total),
            rms(read(&parts.articulation), 1.0),
            1e3 * rms(read(&parts.translation_m2), 3.0),
            rms(read(&parts.rotation_rad2), 3.0).to_degrees(),
        ];
        (parts.objective, BatchValues { samples, values })
    }
}
