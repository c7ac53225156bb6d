//! Mixed precision: convolutions of a training in 16 bits, the rest of it in 32.
//!
//! # Source
//! Micikevicius et al., "Mixed precision training", ICLR 2018.

use burn::module::{Module, ModuleVisitor, Param};
use burn::optim::GradientsParams;
use burn::tensor::{Device, FloatDType, Tensor};
use evpose_task::schedule::TrainingPrecision;

use crate::TrainError;

/// Factor of the loss in `f16`, whose smallest normal number is 6e-5: a power of two, so that nothing is rounded.
const LOSS_SCALE: f32 = 1024.0;

/// The format of a network's inputs, and so of its convolutions.
fn format(precision: TrainingPrecision) -> FloatDType {
    match precision {
        TrainingPrecision::F32 => FloatDType::F32,
        TrainingPrecision::Bf16 => FloatDType::BF16,
        TrainingPrecision::F16 => FloatDType::F16,
    }
}

/// Refuses a device that cannot compute in this precision.
///
/// # Errors
/// If it cannot.
pub fn check(precision: TrainingPrecision, device: &Device) -> Result<(), TrainError> {
    if device.supports_dtype(format(precision)) {
        return Ok(());
    }
    Err(TrainError::Field {
        field: "training.precision",
        message: format!("this device does not compute in {precision:?}: take another, or F32")
            .to_lowercase(),
    })
}

/// Inputs of a network in the format of a training.
pub fn rounded(precision: TrainingPrecision, inputs: Tensor<4>) -> Tensor<4> {
    inputs.cast(format(precision))
}

/// The gradients of `objective`. Where one of them is too large for `f16`, all are zero: the step is left out.
pub fn gradients(
    precision: TrainingPrecision,
    objective: Tensor<1>,
    network: &impl Module,
) -> GradientsParams {
    if precision != TrainingPrecision::F16 {
        return GradientsParams::from_grads(objective.backward(), network);
    }
    let scaled = objective.mul_scalar(LOSS_SCALE).backward();
    let gradients = GradientsParams::from_grads(scaled, network);
    let mut unscaled = Unscaled { factor: LOSS_SCALE.recip(), gradients, sum: None };
    network.visit(&mut unscaled);
    // One infinite or undefined value makes the sum of all so.
    let is_finite = unscaled.sum.take().is_none_or(|sum| sum.into_scalar::<f32>().is_finite());
    if !is_finite {
        unscaled.factor = 0.0;
        network.visit(&mut unscaled);
    }
    unscaled.gradients
}

struct Unscaled {
    factor: f32,
    gradients: GradientsParams,
    /// Of all gradients.
    sum: Option<Tensor<1>>,
}

impl ModuleVisitor for Unscaled {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        let Some(gradient) = self.gradients.remove::<D>(param.id) else { return };
        // Zero times infinity is no number.
        let gradient = if self.factor == 0.0 {
            gradient.zeros_like()
        } else {
            gradient.mul_scalar(self.factor)
        };
        let sum = gradient.clone().sum();
        self.sum = Some(match self.sum.take() {
            Some(before) => before + sum,
            None => sum,
        });
        self.gradients.register(param.id, gradient);
    }
}

#[cfg(test)]
mod tests {
    use burn::tensor::{Distribution, Shape};
    use evpose_nn::{HandRegressor, HandRegressorConfig};

    use super::*;

    /// A small network and 16 windows for it. Tests beside this one share the device's random numbers, so that each
    /// call gives another network: what is compared has to be of one.
    fn network_and_events() -> (HandRegressor, Tensor<4>) {
        let device = Device::flex().autodiff();
        let config = HandRegressorConfig { width: 0.125, ..HandRegressorConfig::default() };
        let shape = Shape::new([16, 2, 64, 96]);
        let events = Tensor::random(shape, Distribution::Uniform(0.0, 1.0), &device);
        (config.init(3, &device).unwrap(), events)
    }

    /// Gradients of the mean square of the outputs, times `factor`, in the order of parameters.
    fn of(
        precision: TrainingPrecision,
        factor: f32,
        (network, events): &(HandRegressor, Tensor<4>),
    ) -> Vec<f32> {
        struct Values<'a>(&'a GradientsParams, Vec<f32>);
        impl ModuleVisitor for Values<'_> {
            fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
                let gradient = self.0.get::<D>(param.id);
                self.1.extend(
                    gradient.into_iter().flat_map(|g| g.into_data().try_to_vec::<f32>().unwrap()),
                );
            }
        }
        let outputs = network.forward(rounded(precision, events.clone()));
        let objective = outputs.square().mean().mul_scalar(factor);
        let gradients = gradients(precision, objective, network);
        let mut values = Values(&gradients, Vec::new());
        network.visit(&mut values);
        values.1
    }

    #[test]
    fn gradients_in_16_bits_point_where_those_in_32_do() {
        let given = network_and_events();
        let whole = of(TrainingPrecision::F32, 1.0, &given);
        let product = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>();
        for precision in [TrainingPrecision::F16, TrainingPrecision::Bf16] {
            let half = of(precision, 1.0, &given);
            assert_eq!(half.len(), whole.len());
            assert_ne!(half, whole);
            // Rounding moves a few values to the other side of a ReLU, which single gradients show.
            let cosine =
                product(&half, &whole) / (product(&half, &half) * product(&whole, &whole)).sqrt();
            assert!(cosine > 0.9, "{precision:?}: {cosine}");
        }
    }

    #[test]
    fn a_step_whose_gradients_are_too_large_is_left_out() {
        let given = network_and_events();
        assert!(of(TrainingPrecision::F16, 1e6, &given).iter().all(|value| *value == 0.0));
        assert!(of(TrainingPrecision::Bf16, 1e6, &given).iter().all(|value| value.is_finite()));
    }
}
