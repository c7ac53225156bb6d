//! The EventHands network: two channels of events to the twelve parameters of a hand.

use burn::module::{self, Module};
use burn::nn::PaddingConfig2d;
use burn::nn::conv::{Conv2d, Conv2dConfig};
use burn::tensor::{Device, Tensor};
use serde::{Deserialize, Serialize};

use crate::NnError;
use crate::backbone::{Backbone, BackboneNet as _, IMAGE_CHANNELS};
use crate::graph::Graph;
use crate::hand_head::HandHead;
use crate::hand_output::RotationOutput;
use crate::initializer::{Initializer, seeded};
use crate::net_ops::NetOps;
use crate::ops::{self, Blocked};
use crate::parameters::{Slot, trained_count};

/// Channels of an event image: OFF and ON events.
pub(crate) const EVENT_CHANNELS: usize = 2;
/// Rows and columns of the first convolution's kernel, as published.
const KERNEL: usize = 3;

/// Shape of a [`HandRegressor`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HandRegressorConfig {
    /// A name of [`BACKBONES`](crate::BACKBONES).
    pub backbone: String,
    /// Channels relative to the published backbone: 0.25 gives ResNet-18 stages of 16, 32, 64 and
    /// 128 channels.
    pub width: f32,
    /// How it expresses rotations.
    pub rotation: RotationOutput,
    /// Parameters, or joints from which they are fitted: see [`HandNetwork`](crate::HandNetwork).
    #[serde(skip_serializing_if = "HandHead::is_default")]
    pub head: HandHead,
}

impl Default for HandRegressorConfig {
    /// The published network.
    fn default() -> Self {
        Self {
            backbone: "resnet18".to_owned(),
            width: 1.0,
            rotation: RotationOutput::default(),
            head: HandHead::default(),
        }
    }
}

/// A convolution from 2 to 3 channels, without activation, in front of an image backbone.
///
/// # Source
/// Rudnev et al.: *EventHands: Real-Time Neural 3D Hand Pose Estimation from an Event Stream*,
/// ICCV 2021. With ResNet-18 it has 11,182,725 parameters.
#[derive(Module, Debug)]
pub struct HandRegressor {
    /// Weight of shape `[3, 2, 3, 3]`, bias of shape `[3]`.
    conv1: Conv2d,
    backbone: Backbone,
    #[module(skip)]
    config: HandRegressorConfig,
}

impl HandRegressorConfig {
    /// The network with initial weights drawn from `seed`, as torchvision draws them.
    ///
    /// # Errors
    /// [`NnError::UnknownBackbone`] and [`NnError::Width`].
    pub fn init(&self, seed: u64, device: &Device) -> Result<HandRegressor, NnError> {
        let network = self.zeros(device)?;
        let backbone = network.backbone.clone();
        Ok(seeded(network, seed, |slot| match slot.path.strip_prefix("backbone.") {
            Some(_) => backbone.initializer(slot),
            None => Initializer::torch_default(EVENT_CHANNELS * KERNEL * KERNEL),
        }))
    }

    /// The number of trainable parameters.
    ///
    /// # Errors
    /// As [`init`](Self::init).
    pub fn parameter_count(&self) -> Result<usize, NnError> {
        Ok(trained_count(&self.zeros(&Device::flex())?))
    }

    /// The network with all weights zero.
    pub(crate) fn zeros(&self, device: &Device) -> Result<HandRegressor, NnError> {
        let conv1 = Conv2dConfig::new([EVENT_CHANNELS, IMAGE_CHANNELS], [KERNEL, KERNEL])
            .with_padding(PaddingConfig2d::Explicit(1, 1, 1, 1))
            .with_initializer(module::Initializer::Zeros)
            .init(device);
        let backbone =
            Backbone::build(&self.backbone, self.width, self.rotation.outputs(), device)?;
        Ok(HandRegressor { conv1, backbone, config: self.clone() })
    }
}

impl HandRegressor {
    /// The twelve hand parameters in their published order: see
    /// [`HandParams::from_array`](evpose_pose::HandParams::from_array).
    ///
    /// # Shapes
    /// - events: `[batch, 2, height, width]`, values in [0, 1]
    /// - output: `[batch, 12]`, or 15 of them: see [`RotationOutput`]
    pub fn forward(&self, events: Tensor<4>) -> Tensor<2> {
        if ops::is_ours(&events) {
            return self.forward_ops(Blocked::from_planes(events));
        }
        self.forward_ops(events)
    }

    /// The graph of the network, for engines that compile it.
    pub fn graph(&self) -> Graph {
        Graph::trace(self, EVENT_CHANNELS, |events| vec![self.forward_ops(events)])
    }

    pub(crate) fn forward_ops<N: NetOps>(&self, events: N) -> N::Vector {
        self.backbone.forward(events.conv(&self.conv1))
    }

    /// The configuration that it was built from.
    pub fn config(&self) -> &HandRegressorConfig {
        &self.config
    }

    /// The name of the tensor in `slot` in the published PyTorch checkpoints.
    pub(crate) fn pytorch_name(&self, slot: &Slot) -> String {
        let path = match slot.path.strip_prefix("backbone.") {
            Some(path) => format!("rn.{}", self.backbone.torchvision_path(path)),
            None => slot.path.clone(),
        };
        // PyTorch names the parameters of a normalisation as those of any layer.
        match path.rsplit_once('.') {
            Some((layer, "gamma")) => format!("{layer}.weight"),
            Some((layer, "beta")) => format!("{layer}.bias"),
            _ => path,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BACKBONES;
    use crate::parameters::{read, slots};
    use burn::tensor::Distribution;

    fn config(backbone: &str, width: f32) -> HandRegressorConfig {
        HandRegressorConfig {
            backbone: backbone.to_owned(),
            width,
            ..HandRegressorConfig::default()
        }
    }

    /// A section per backbone: `[name] count parameters`, then `name shape` of every tensor.
    const TORCHVISION: &str = include_str!("../tests/data/torchvision_names.txt");

    #[test]
    fn names_shapes_and_counts_are_those_of_torchvision() {
        let sections =
            TORCHVISION.split('[').skip(1).map(|section| section.split_once('\n').unwrap());
        let mut seen = 0;
        for (title, tensors) in sections {
            let (name, count) = title.split_once("] ").unwrap();
            let network = config(name, 1.0).zeros(&Device::flex()).unwrap();
            assert_eq!(format!("{} parameters", trained_count(&network)), count, "{name}");
            let ours: Vec<_> = slots(&network)
                .into_iter()
                .map(|mut slot| {
                    // PyTorch stores linear weights by outputs first.
                    if slot.is_linear_weight() {
                        slot.shape.reverse();
                    }
                    let shape: Vec<_> = slot.shape.iter().map(usize::to_string).collect();
                    format!("{} {}", network.pytorch_name(&slot), shape.join("x"))
                })
                .collect();
            assert_eq!(ours, tensors.lines().collect::<Vec<_>>(), "{name}");
            seen += 1;
        }
        assert_eq!(seen, BACKBONES.len());
    }

    #[test]
    fn a_graph_has_every_layer_by_its_path() {
        for entry in &BACKBONES {
            let network = config(entry.name, 0.25).init(3, &Device::flex()).unwrap();
            let graph = network.graph();
            let convolutions = slots(&network);
            let weights = convolutions.iter().filter(|slot| slot.name() == "weight");
            for slot in weights {
                let layer = slot.path.strip_suffix(".weight").unwrap();
                let layer = layer.strip_suffix(".conv").unwrap_or(layer);
                let count = graph.nodes.iter().filter(|node| node.name == layer).count();
                assert_eq!(count, 1, "{}: {layer}", entry.name);
            }
            assert_eq!(graph.outputs, [graph.nodes.len() - 1]);
            assert_eq!(graph.nodes[graph.outputs[0]].channels, 12);
            for (id, node) in graph.nodes.iter().enumerate() {
                assert!(node.inputs.iter().all(|input| *input < id), "{}", node.name);
            }
        }
    }

    #[test]
    fn a_seed_gives_the_same_weights_in_any_thread() {
        let weights = |seed| read(&config("resnet18", 0.0625).init(seed, &Device::flex()).unwrap());
        let here = weights(7);
        let there: Vec<_> = std::thread::scope(|scope| {
            let threads = [(); 4].map(|()| scope.spawn(|| weights(7)));
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        assert!(there.iter().all(|weights| *weights == here));
        assert!(weights(8) != here);
    }

    /// The standard deviation of torchvision's initial weights, from the shape of the weight; none
    /// for zeros.
    type Spread = fn(&[usize]) -> Option<f64>;

    /// By backbone: of convolutions, then of fully connected weights and biases.
    const SPREADS: [(&str, Spread, Spread); 5] = [
        ("resnet18", kaiming, |_| Some((1.0 / 512.0 / 3.0f64).sqrt())),
        ("mobilenet_v2", kaiming, |shape| (shape.len() == 2).then_some(0.01)),
        ("vgg11_bn", kaiming, |shape| (shape.len() == 2).then_some(0.01)),
        (
            "shufflenet_v2",
            |shape| Some((1.0 / shape[1..].iter().product::<usize>() as f64 / 3.0).sqrt()),
            |_| Some((1.0 / 1024.0 / 3.0f64).sqrt()),
        ),
        ("mnasnet", kaiming, |shape| (shape.len() == 2).then_some((1.0 / 12.0f64).sqrt())),
    ];

    fn kaiming(shape: &[usize]) -> Option<f64> {
        let &[out, _, ky, kx] = shape else { return None };
        Some((2.0 / (out * ky * kx) as f64).sqrt())
    }

    #[test]
    fn first_weights_have_the_spread_of_torchvision() {
        for (name, convolution, linear) in SPREADS {
            // The full VGG takes seconds; nothing here depends on its width.
            let width = if name == "vgg11_bn" { 0.125 } else { 1.0 };
            let network = config(name, width).init(3, &Device::flex()).unwrap();
            for (slot, values) in read(&network) {
                let expected = match (slot.layer.as_str(), slot.shape.as_slice()) {
                    _ if slot.path.starts_with("conv1") => Some((1.0 / 18.0 / 3.0f64).sqrt()),
                    ("Conv2d", shape) => convolution(shape),
                    ("Linear", shape) => linear(shape),
                    _ => None,
                };
                let Some(expected) = expected else {
                    let one = matches!(slot.name(), "gamma" | "running_var");
                    assert!(values.iter().all(|&v| v == f32::from(one)), "{name} {}", slot.path);
                    continue;
                };
                let square: f64 = values.iter().map(|&v| f64::from(v).powi(2)).sum();
                let deviation = (square / values.len() as f64).sqrt();
                // Six standard errors of a deviation.
                let tolerance = 6.0 / (2.0 * values.len() as f64).sqrt();
                assert!((deviation / expected - 1.0).abs() < tolerance, "{name} {}", slot.path);
            }
        }
    }

    #[test]
    fn every_backbone_trains_at_odd_sizes_and_narrow_widths() {
        let device = Device::flex().autodiff();
        for entry in &BACKBONES {
            // As small as it goes, and both sides odd.
            let side = entry.smallest_px.max(9) | 1;
            let network = config(entry.name, 0.03).init(1, &device).unwrap();
            let shape = [3, 2, side, side + 2];
            let input = Tensor::<4>::random(shape, Distribution::Uniform(0.0, 1.0), &device);
            let output = network.forward(input);
            assert_eq!(output.dims(), [3, 12]);
            let gradients = output.powi_scalar(2).mean().backward();
            let gradient = network.conv1.weight.grad(&gradients).unwrap();
            let values: Vec<f32> = gradient.into_data().iter().collect();
            assert!(values.iter().all(|v| v.is_finite()), "{}", entry.name);
            assert!(values.iter().any(|v| *v != 0.0), "{}: nothing to learn from", entry.name);
        }
    }

    #[test]
    fn unknown_backbones_and_impossible_widths_are_refused() {
        let error = |backbone, width| {
            config(backbone, width).zeros(&Device::flex()).map(|_| ()).unwrap_err().to_string()
        };
        assert_eq!(
            error("vgg", 1.0),
            "no backbone is called `vgg`: choose one of resnet18, resnet34, mobilenet_v2, \
             vgg11_bn, vgg13_bn, vgg16_bn, vgg19_bn, shufflenet_v2, mnasnet, inception_v3"
        );
        for width in [0.0, -1.0, f32::NAN, 1e9] {
            assert!(error("resnet18", width).starts_with("`width` must"), "{width}");
        }
    }
}
