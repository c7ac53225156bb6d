//! The loss of EventHands: squared errors of articulation, translation and rotation, each in units
//! of its own spread, and the logarithm of their sum as the objective.

use burn::tensor::Tensor;
use evpose_pose::PARAMETERS;
use serde::{Deserialize, Serialize};

/// The six articulation coefficients among the twelve hand parameters.
const ARTICULATION: std::ops::Range<usize> = 0..6;
/// The position of the wrist.
const TRANSLATION: std::ops::Range<usize> = 6..9;
/// The first output of the wrist's rotation.
const ROTATION: usize = 9;
/// Components of a rotation vector.
const ROTATION_PARAMETERS: usize = 3;
/// Mean square error of a rotation vector's components over that of six entries of the matrix, for
/// small angles: `(θ² / 3) / (2 θ² / 9)`.
const SIX_D_RAD2: f32 = 1.5;
/// The z coordinate of the wrist.
const DEPTH: std::ops::Range<usize> = 8..9;

/// The scales of the loss: the mean squared error at which each part counts one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HandLossConfig {
    /// Of the articulation coefficients, dimensionless.
    pub articulation: f32,
    /// Of the position, in square metres.
    pub translation_m2: f32,
    /// Of the rotation vector, in square radians.
    pub rotation_rad2: f32,
}

impl Default for HandLossConfig {
    /// The published scales.
    fn default() -> Self {
        Self { articulation: 0.1, translation_m2: 0.0001, rotation_rad2: 0.05 }
    }
}

/// The loss of EventHands.
///
/// # Model
/// With `m`, `t`, `r` the mean squared errors over a batch of the 6 articulation coefficients, the
/// 3 coordinates and the 3 components of the rotation vector, and `a` the scales,
/// `L = (6 m / a_m + 3 t / a_t + 3 r / a_r) / 12`. Training minimises `log10 L`, which keeps the
/// size of its gradient while `L` falls by orders of magnitude.
///
/// # Source
/// Rudnev et al.: *EventHands*, ICCV 2021, and its published code.
#[derive(Debug, Clone, Copy, Default)]
pub struct HandLoss {
    config: HandLossConfig,
}

/// A [`HandLoss`] and its parts, each of shape `[1]`.
#[derive(Debug, Clone)]
pub struct HandLossParts {
    /// `log10 L`, the objective of training. Minus infinity for a perfect prediction.
    pub objective: Tensor<1>,
    /// `L`, the loss that validation reports.
    pub total: Tensor<1>,
    /// Mean squared error of the articulation coefficients.
    pub articulation: Tensor<1>,
    /// Mean squared error of the wrist's coordinates in square metres.
    pub translation_m2: Tensor<1>,
    /// Mean squared error of the wrist's z coordinate in square metres.
    pub depth_m2: Tensor<1>,
    /// Mean squared error of the rotation vector's components in square radians; of rotations in 6D,
    /// what it would be for small errors.
    pub rotation_rad2: Tensor<1>,
}

impl HandLoss {
    /// The loss with these scales.
    pub fn new(config: HandLossConfig) -> Self {
        Self { config }
    }

    /// # Shapes
    /// - prediction, target: `[batch, 12]`, or `[batch, 15]` with rotations in 6D
    ///
    /// # Panics
    /// If the shapes differ.
    pub fn forward(&self, prediction: Tensor<2>, target: Tensor<2>) -> HandLossParts {
        let squared = (prediction - target).square();
        let mean = |part: std::ops::Range<usize>| {
            squared.clone().slice([0..squared.dims()[0], part]).mean()
        };
        let (articulation, translation_m2) = (mean(ARTICULATION), mean(TRANSLATION));
        let outputs = squared.dims()[1];
        let (depth_m2, rotation) = (mean(DEPTH), mean(ROTATION..outputs));
        let rotation_rad2 = if outputs == PARAMETERS { rotation } else { rotation * SIX_D_RAD2 };
        // Means are weighted by their counts, so that with equal scales the total is the mean of
        // all.
        let weight = |count: usize, scale| count as f32 / PARAMETERS as f32 / scale;
        let total = articulation.clone() * weight(ARTICULATION.len(), self.config.articulation)
            + translation_m2.clone() * weight(TRANSLATION.len(), self.config.translation_m2)
            + rotation_rad2.clone() * weight(ROTATION_PARAMETERS, self.config.rotation_rad2);
        let objective = total.clone().log() * std::f32::consts::LOG10_E;
        HandLossParts { objective, total, articulation, translation_m2, depth_m2, rotation_rad2 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use burn::tensor::{Device, TensorData};
    use proptest::prelude::*;

    fn parts(prediction: &[[f32; 12]], target: &[[f32; 12]]) -> HandLossParts {
        let device = Device::flex();
        let tensor = |rows: &[[f32; 12]]| {
            Tensor::from_data(TensorData::new(rows.concat(), [rows.len(), 12]), &device)
        };
        HandLoss::default().forward(tensor(prediction), tensor(target))
    }

    fn close(tensor: Tensor<1>, expected: f32) {
        let value = tensor.into_scalar::<f32>();
        assert!((value - expected).abs() <= 1e-5 * expected.abs(), "{value} for {expected}");
    }

    #[test]
    fn an_error_of_one_scale_in_every_parameter_costs_one() {
        let (m, t, r) = (0.1f32.sqrt(), 0.01, 0.05f32.sqrt());
        let error = [m, m, m, m, m, m, t, t, t, r, r, r];
        let parts = parts(&[error, error.map(|e| -e)], &[[0.0; 12]; 2]);
        close(parts.total, 1.0);
        assert!(parts.objective.into_scalar::<f32>().abs() < 1e-5);
    }

    #[test]
    fn a_centimetre_of_depth_alone_costs_a_twelfth() {
        let mut prediction = [0.0; 12];
        prediction[8] = 0.01;
        let parts = parts(&[prediction], &[[0.0; 12]]);
        close(parts.depth_m2, 1e-4);
        close(parts.translation_m2, 1e-4 / 3.0);
        close(parts.objective, (1.0f32 / 12.0).log10());
        close(parts.total, 1.0 / 12.0);
    }

    #[test]
    fn the_gradient_of_the_objective_does_not_shrink_with_the_error() {
        let device = Device::flex().autodiff();
        let norm = |error: f32| {
            let x = Tensor::<2>::full([1, 12], error, &device).require_grad();
            let loss = HandLoss::default().forward(x.clone(), Tensor::zeros([1, 12], &device));
            let gradients = loss.objective.backward();
            let gradient = x.grad(&gradients).map(|g| g.square().sum().into_scalar::<f32>());
            gradient.map_or(0.0, f32::sqrt) * error
        };
        // d log10 L = (2 / ln 10) dx / x in the direction of the error itself.
        let (large, small) = (norm(1.0), norm(1e-3));
        assert!(large > 0.0 && (large / small - 1.0).abs() < 1e-4, "{large} {small}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn the_loss_is_symmetric_and_quadratic(
            a in prop::array::uniform12(-1.0f32..1.0),
            b in prop::array::uniform12(-1.0f32..1.0),
        ) {
            let (ab, ba) = (parts(&[a], &[b]), parts(&[b], &[a]));
            let total = ab.total.into_scalar::<f32>();
            prop_assert_eq!(total, ba.total.into_scalar::<f32>());
            let twice = parts(&[a.map(|x| 2.0 * x)], &[b.map(|x| 2.0 * x)]);
            prop_assert!((twice.total.into_scalar::<f32>() / total - 4.0).abs() < 1e-4);
        }
    }
}
