//! Anything that turns windows of events into poses.

use burn::tensor::{Device, Tensor, TensorData};
use evpose_nn::HandRegressor;
use evpose_pose::{HandParams, PARAMETERS};

use crate::TrainError;

/// Turns windows of events into poses: a network, a constant, later a compiled engine.
pub trait Predictor {
    /// Poses of `surfaces`, which holds whole windows of `[2, height, width]`, one after another;
    /// `image_size` is `(height, width)`.
    ///
    /// # Errors
    /// If the computation fails or yields something that is not a number.
    fn predict(
        &mut self,
        surfaces: &[f32],
        image_size: (usize, usize),
    ) -> Result<Vec<HandParams>, TrainError>;
}

/// The network on a device.
#[derive(Debug)]
pub struct NetworkPredictor {
    network: HandRegressor,
    device: Device,
}

impl NetworkPredictor {
    /// Predicts with `network`, which must live on `device`.
    pub fn new(network: HandRegressor, device: Device) -> Self {
        Self { network, device }
    }
}

impl Predictor for NetworkPredictor {
    fn predict(
        &mut self,
        surfaces: &[f32],
        (height, width): (usize, usize),
    ) -> Result<Vec<HandParams>, TrainError> {
        let count = surfaces.len() / (2 * height * width);
        let shape = [count, 2, height, width];
        let input = Tensor::<4>::from_data(TensorData::new(surfaces.to_vec(), shape), &self.device);
        let values: Vec<f32> = self.network.forward(input).into_data().iter().collect();
        if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            return Err(TrainError::Stopped(format!(
                "the network predicted {value}: the checkpoint is damaged or diverged"
            )));
        }
        let (poses, _) = values.as_chunks::<PARAMETERS>();
        Ok(poses.iter().map(|&pose| HandParams::from_array(pose)).collect())
    }
}

/// Always the same pose: what a network has to beat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstantPose(pub HandParams);

impl Predictor for ConstantPose {
    fn predict(
        &mut self,
        surfaces: &[f32],
        (height, width): (usize, usize),
    ) -> Result<Vec<HandParams>, TrainError> {
        Ok(vec![self.0; surfaces.len() / (2 * height * width)])
    }
}
