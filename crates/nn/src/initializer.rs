//! Initial weights from a seed.
//!
//! Every tensor draws from its own generator, named by its path: the same seed gives the same
//! network on any thread, on any device and in any order of construction, and a layer added
//! to a network does not move the weights of the others.

use burn::module::Module;
use evpose_core::CounterRng;

use crate::parameters::{Slot, fill};

/// The distribution of the initial values of a tensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Initializer {
    /// Every value the same.
    Constant(f32),
    /// Uniform within plus or minus `bound`.
    Uniform {
        /// Half of the range.
        bound: f32,
    },
    /// Normal about zero.
    Normal {
        /// Standard deviation.
        deviation: f32,
    },
}

impl Initializer {
    /// Kaiming normal, `fan_out` mode.
    ///
    /// # Model
    /// Deviation `sqrt(2 / fan_out)`, `fan_out` the output channels times the kernel's area:
    /// ReLUs halve the variance of gradients, the 2 restores it.
    ///
    /// # Source
    /// He et al.: *Delving Deep into Rectifiers*, ICCV 2015, with the fan of torchvision's ResNet
    /// and MobileNetV2, which do not divide by the groups of a depthwise convolution.
    pub fn kaiming_fan_out(weight_shape: &[usize]) -> Self {
        let [channels_out, _, kernel_y, kernel_x] = *weight_shape else {
            return Self::Constant(0.0);
        };
        Self::Normal { deviation: (2.0 / (channels_out * kernel_y * kernel_x) as f32).sqrt() }
    }

    /// Kaiming normal, `fan_in` mode.
    ///
    /// # Model
    /// Deviation `sqrt(2 / fan_in)`, `fan_in` the terms that an output sums up: ReLUs halve the
    /// variance of values, the 2 restores it.
    ///
    /// # Source
    /// As [`kaiming_fan_out`](Self::kaiming_fan_out), with the default fan of PyTorch.
    pub fn kaiming_fan_in(weight_shape: &[usize]) -> Self {
        let fan_in: usize = weight_shape.iter().skip(1).product();
        Self::Normal { deviation: (2.0 / fan_in as f32).sqrt() }
    }

    /// Xavier uniform, the default of Keras.
    ///
    /// # Model
    /// Within `sqrt(6 / (fan_in + fan_out))`, the fans the channels times the kernel's area.
    ///
    /// # Source
    /// Glorot, Bengio: *Understanding the difficulty of training deep feedforward neural networks*,
    /// AISTATS 2010.
    pub fn xavier_uniform(weight_shape: &[usize]) -> Self {
        let [channels_out, channels_in, kernel_y, kernel_x] = *weight_shape else {
            return Self::Constant(0.0);
        };
        let fans = (channels_out + channels_in) * kernel_y * kernel_x;
        Self::Uniform { bound: (6.0 / fans as f32).sqrt() }
    }

    /// PyTorch's default for the weight and bias of linear layers and convolutions.
    pub fn torch_default(fan_in: usize) -> Self {
        Self::Uniform { bound: 1.0 / (fan_in as f32).sqrt() }
    }

    /// The tensor `name` of a batch normalisation that starts as the identity.
    pub fn batch_norm(name: &str) -> Self {
        Self::Constant(if matches!(name, "gamma" | "running_var") { 1.0 } else { 0.0 })
    }

    fn draw(self, count: usize, rng: &mut CounterRng) -> Vec<f32> {
        let value = || match self {
            Self::Constant(value) => value,
            Self::Uniform { bound } => rng.uniform(-bound, bound),
            Self::Normal { deviation } => deviation * rng.normal(),
        };
        std::iter::repeat_with(value).take(count).collect()
    }
}

/// Gives every tensor of `module` its initial values; the seed and its path decide each.
pub fn seeded<M: Module>(module: M, seed: u64, initial: impl Fn(&Slot) -> Initializer) -> M {
    fill(module, |slot| {
        let mut rng = CounterRng::new(seed, &slot.path, 0);
        initial(slot).draw(slot.shape.iter().product(), &mut rng)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn deviation(values: &[f32]) -> f64 {
        let sum: f64 = values.iter().map(|&v| f64::from(v).powi(2)).sum();
        (sum / values.len() as f64).sqrt()
    }

    #[test]
    fn initializers_have_their_published_spread() {
        let mut rng = CounterRng::new(1, "test", 0);
        let shape = [64, 3, 7, 7];
        let count = 200_000;
        let kaiming = Initializer::kaiming_fan_out(&shape).draw(count, &mut rng);
        assert!((deviation(&kaiming) / (2.0f64 / (64.0 * 49.0)).sqrt() - 1.0).abs() < 0.01);
        let linear = Initializer::torch_default(512).draw(count, &mut rng);
        let bound = 1.0 / 512f32.sqrt();
        assert!(linear.iter().all(|v| v.abs() <= bound));
        assert!((deviation(&linear) / f64::from(bound) * 3f64.sqrt() - 1.0).abs() < 0.01);
    }
}
