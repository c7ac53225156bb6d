//! The optimiser of all trainings.

use burn::optim::LearningRate;
use burn::optim::decay::WeightDecayConfig;
use burn::optim::{AdamConfig, AdamState, Optimizer};
use burn::tensor::{Device, Tensor};

/// PyTorch's default; Burn's is 1e-5.
const EPSILON: f32 = 1e-8;

/// Adam with PyTorch's epsilon and, above 0, a weight decay. On GPUs a step of a parameter is one kernel in
/// place of fifteen.
///
/// # Source
/// Kingma and Ba, "Adam: a method for stochastic optimization", 2015.
#[derive(Clone)]
pub struct Adam {
    by_burn: burn::optim::Adam,
    #[cfg(feature = "gpu-kernels")]
    weight_decay: f32,
}

impl std::fmt::Debug for Adam {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Adam").finish_non_exhaustive()
    }
}

impl Adam {
    /// The optimiser with this weight decay.
    pub fn new(weight_decay: f32) -> Self {
        // A decay of zero would still cost Burn a pass over every parameter.
        let decay = (weight_decay > 0.0).then(|| WeightDecayConfig::new(weight_decay));
        let config = AdamConfig::new().with_epsilon(EPSILON).with_weight_decay(decay);
        Self {
            by_burn: config.build(),
            #[cfg(feature = "gpu-kernels")]
            weight_decay,
        }
    }
}

impl Optimizer for Adam {
    type State<const D: usize> = AdamState<D>;

    fn step<const D: usize>(
        &self,
        learning_rate: LearningRate,
        parameter: Tensor<D>,
        gradient: Tensor<D>,
        state: Option<AdamState<D>>,
    ) -> (Tensor<D>, Option<AdamState<D>>) {
        #[cfg(feature = "gpu-kernels")]
        if crate::ops::gpu_adam::suits(&parameter) {
            let (parameter, state) = self.on_gpu(learning_rate, parameter, gradient, state);
            return (parameter, Some(state));
        }
        self.by_burn.step(learning_rate, parameter, gradient, state)
    }

    fn to_device<const D: usize>(state: AdamState<D>, device: &Device) -> AdamState<D> {
        <burn::optim::Adam as Optimizer>::to_device(state, device)
    }
}

#[cfg(feature = "gpu-kernels")]
impl Adam {
    fn on_gpu<const D: usize>(
        &self,
        learning_rate: LearningRate,
        parameter: Tensor<D>,
        gradient: Tensor<D>,
        state: Option<AdamState<D>>,
    ) -> (Tensor<D>, AdamState<D>) {
        use crate::ops::gpu_adam::{AdamStep, step};
        use burn::optim::AdaptiveMomentumState;

        let (time, moments) = match state {
            Some(AdamState { momentum }) => {
                (momentum.time + 1, [momentum.moment_1, momentum.moment_2])
            }
            None => (1, [parameter.zeros_like(), parameter.zeros_like()]),
        };
        let settings = AdamStep {
            learning_rate: learning_rate as f32,
            weight_decay: self.weight_decay,
            // The publication's, and Burn's defaults.
            beta_1: 0.9,
            beta_2: 0.999,
            epsilon: EPSILON,
            // Long before that many steps both corrections have become 1.
            time: i32::try_from(time).unwrap_or(i32::MAX),
        };
        let (parameter, [first, second]) = step(parameter, gradient, moments, settings);
        (parameter, AdamState::new(AdaptiveMomentumState::new(time, first, second)))
    }
}

#[cfg(all(test, feature = "wgpu"))]
mod tests {
    use burn::tensor::{Device, Tensor, TensorData};

    use super::*;
    use crate::DeviceKind;

    /// A parameter after three steps, by gradients that change their signs.
    fn stepped(device: &Device) -> Vec<f32> {
        let adam = Adam::new(0.01);
        let values = |phase: f32| {
            let values: Vec<f32> = (0..70).map(|k| (k as f32 * 0.7 + phase).sin()).collect();
            Tensor::<2>::from_data(TensorData::new(values, [10, 7]), device)
        };
        let (mut parameter, mut state) = (values(0.3), None);
        for step in 0..3 {
            // Gradients of weights come with exchanged axes.
            let gradient = values(step as f32).reshape([7, 10]).swap_dims(0, 1);
            (parameter, state) = adam.step(0.1, parameter, gradient, state);
        }
        parameter.into_data().iter::<f32>().collect()
    }

    #[test]
    #[ignore = "needs an adapter of wgpu, a GPU or Mesa's software: `cargo xtask slow` runs it"]
    fn steps_on_a_gpu_are_those_of_burn() {
        let gpu = (DeviceKind::Wgpu { adapter: None }).resolve().expect("an adapter of wgpu");
        for (ours, burns) in stepped(&gpu).into_iter().zip(stepped(&Device::flex())) {
            assert!((ours - burns).abs() < 1e-6, "{ours} for {burns}");
        }
    }
}
