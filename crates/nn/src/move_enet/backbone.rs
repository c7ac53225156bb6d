//! MobileNetV2 down to a 32nd of the image, and a feature pyramid back up to a quarter of it.

use burn::module::Module;
use burn::nn::conv::Conv2d;
use burn::tensor::Device;

use super::blocks::{InvertedResidual, Separable, Upsampling, pointwise};
use super::{IMAGE_CHANNELS, MoveEnetConfig};
use crate::channels::multiple_of_eight;
use crate::conv_norm::{ConvNorm, ConvNormConfig};
use crate::net_ops::NetOps;

/// Channels of the first convolution, and of the separable one behind it.
const STEM: [f32; 2] = [32.0, 16.0];
/// Output channels, stride and repetitions of the inverted residuals.
const STAGES: [(f32, usize, usize); 6] =
    [(24.0, 2, 1), (32.0, 2, 2), (64.0, 2, 3), (96.0, 1, 2), (160.0, 2, 2), (320.0, 1, 0)];
/// Levels of the pyramid: the outputs of the first stages, at a quarter, an eighth and a 16th.
const LEVELS: usize = 3;
/// Channels of the widest convolution.
const WIDE: f32 = 1280.0;

/// The encoder and the feature pyramid.
#[derive(Module, Debug)]
pub(crate) struct Pyramid {
    stem: ConvNorm,
    separable: Separable,
    stages: Vec<InvertedResidual>,
    widen: ConvNorm,
    narrow: Conv2d,
    /// Entry `i` goes from level `i + 1` to the finer level `i`.
    upsamplings: Vec<Upsampling>,
    /// The 1x1 convolutions of the lateral connections, one a level.
    laterals: Vec<Conv2d>,
    smooth: Separable,
}

/// Channels of the finest level of a pyramid `width` times as wide as published.
pub(crate) fn channels(width: f32) -> usize {
    multiple_of_eight(STAGES[0].0 * width)
}

impl Pyramid {
    pub(crate) fn new(config: &MoveEnetConfig, device: &Device) -> Self {
        let wide = |published: f32| multiple_of_eight(published * config.width);
        let [first, second] = STEM.map(wide);
        let mut channels_in = second;
        let stage = |(published, stride, repetitions)| {
            let channels = [channels_in, config.expansion * channels_in, wide(published)];
            channels_in = channels[2];
            InvertedResidual::new(channels, stride, repetitions, device)
        };
        let stages: Vec<_> = STAGES.into_iter().map(stage).collect();
        let levels: Vec<usize> = STAGES[..LEVELS].iter().map(|stage| wide(stage.0)).collect();
        let upsampling = |pair: &[usize]| Upsampling::new(pair[1], pair[0], device);
        Self {
            stem: ConvNormConfig::new(IMAGE_CHANNELS, first, 3).with_stride(2).init(device),
            separable: Separable::new(first, second, device),
            stages,
            widen: ConvNormConfig::new(channels_in, wide(WIDE), 1).init(device),
            narrow: pointwise(wide(WIDE), levels[LEVELS - 1], false, device),
            upsamplings: levels.windows(2).map(upsampling).collect(),
            laterals: levels.iter().map(|width| pointwise(*width, *width, true, device)).collect(),
            smooth: Separable::new(levels[0], levels[0], device),
        }
    }

    /// # Shapes
    /// - input: `[batch, channels_in, height, width]`, sides multiples of 32
    /// - output: `[batch, channels, height / 4, width / 4]`
    pub(crate) fn forward<F: NetOps>(&self, input: F) -> F {
        let mut x = self.separable.forward_relu_between(self.stem.forward_relu(input));
        let mut levels = Vec::with_capacity(LEVELS);
        // The first levels are kept for the way back up, where the coarse ones are added to them.
        for (index, stage) in self.stages.iter().enumerate() {
            x = stage.forward(x);
            if index < LEVELS {
                levels.push(x.clone());
            }
        }
        let mut x = self.widen.forward_relu(x).conv(&self.narrow).upsample();
        for (index, (level, lateral)) in levels.into_iter().zip(&self.laterals).enumerate().rev() {
            // From the coarsest level to the finest; the finest is not upsampled any more.
            x = x.add(level.conv(lateral));
            if index > 0 {
                x = self.upsamplings[index - 1].forward(x);
            }
        }
        self.smooth.forward_relu_behind(x)
    }
}
