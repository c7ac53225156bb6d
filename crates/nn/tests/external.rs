//! A backbone of another crate inside the hand network: it is computed, trained, traced and stored
//! as a built-in one.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::sync::Once;

use burn::module::Module;
use burn::nn::Linear;
use burn::nn::pool::{AdaptiveAvgPool2d, AdaptiveAvgPool2dConfig};
use burn::optim::{GradientsParams, SgdConfig};
use burn::tensor::{Device, Tensor, TensorData};
use evpose_nn::backbone::{
    BackboneNet, BackboneSpec, ConvNorm, ConvNormConfig, Initializer, NetOps, Slot, VectorOps,
    linear, scaled,
};
use evpose_nn::parameters::{fill, read, slots, trained_count};
use evpose_nn::{BACKBONES, BackboneEntry, HandRegressor, HandRegressorConfig, NnError};

static ENTRY: BackboneEntry = BackboneEntry::external(&SPEC);
static SPEC: BackboneSpec<Single> = BackboneSpec {
    name: "single",
    about: "one convolution",
    smallest_px: 1,
    narrowest: 1.0 / 16.0,
    build: |width, outputs, device| {
        let channels = scaled(16, width);
        Single {
            first: ConvNormConfig::new(3, channels, 3).with_stride(2).init(device),
            pool: AdaptiveAvgPool2dConfig::new([1, 1]).init(),
            head: linear(channels, outputs, device),
        }
    },
};

#[derive(Module, Debug)]
struct Single {
    first: ConvNorm,
    pool: AdaptiveAvgPool2d,
    head: Linear,
}

impl BackboneNet for Single {
    fn forward<N: NetOps>(&self, images: N) -> N::Vector {
        self.first.forward_relu(images).avg_pool(&self.pool).linear(&self.head)
    }

    fn initializer(&self, slot: &Slot) -> Initializer {
        match slot.layer.as_str() {
            "Conv2d" => Initializer::kaiming_fan_out(&slot.shape),
            "BatchNorm" => Initializer::batch_norm(slot.name()),
            _ => Initializer::torch_default(self.head.weight.dims()[0]),
        }
    }
}

fn config() -> HandRegressorConfig {
    static REGISTERED: Once = Once::new();
    REGISTERED.call_once(|| BACKBONES.register(&[&ENTRY]).unwrap());
    HandRegressorConfig { backbone: "single".to_owned(), ..HandRegressorConfig::default() }
}

fn images(batch: usize) -> TensorData {
    let values: Vec<f32> = (0..batch * 2 * 16 * 16).map(|i| (i * 7 % 13) as f32 / 13.0).collect();
    TensorData::new(values, [batch, 2, 16, 16])
}

/// The network after one step of gradient descent.
fn step(network: HandRegressor, device: &Device) -> HandRegressor {
    let output = network.forward(Tensor::from_data(images(4), device));
    let gradients = GradientsParams::from_grads(output.square().mean().backward(), &network);
    SgdConfig::new().init().step(0.1, network, gradients)
}

#[test]
fn its_tensors_have_the_paths_of_its_fields() {
    let network = config().init(7, &Device::flex()).unwrap();
    let paths: Vec<String> = slots(&network).into_iter().map(|slot| slot.path).collect();
    assert_eq!(
        paths,
        [
            "conv1.weight",
            "conv1.bias",
            "backbone.first.conv.weight",
            "backbone.first.norm.gamma",
            "backbone.first.norm.beta",
            "backbone.first.norm.running_mean",
            "backbone.first.norm.running_var",
            "backbone.head.weight",
            "backbone.head.bias",
        ]
    );
    // 2 to 3 channels and bias, 3 to 16 channels, scale and shift, 16 to 12 values and bias.
    assert_eq!(trained_count(&network), 57 + 432 + 32 + 204);
    assert_eq!(network.num_params(), trained_count(&network) + 32);
    let names = network.graph().nodes.into_iter().map(|node| node.name);
    assert!(names.into_iter().any(|name| name == "backbone.first"));
}

#[test]
fn kernels_and_burn_train_it_alike() {
    let device = Device::flex().autodiff();
    // Copies of a network share their running means.
    let untrained = || config().init(7, &device).unwrap();
    let ours = read(&step(untrained(), &device));
    evpose_nn::set_training_kernels(false);
    let theirs = read(&step(untrained(), &device));
    evpose_nn::set_training_kernels(true);
    for (((slot, ours), (_, theirs)), (_, untrained)) in
        ours.iter().zip(&theirs).zip(&read(&untrained()))
    {
        for (ours, theirs) in ours.iter().zip(theirs) {
            assert!((ours - theirs).abs() < 1e-4, "{}: {ours}, Burn {theirs}", slot.path);
        }
        assert!(ours != untrained, "{} stays as it was", slot.path);
    }
}

#[test]
fn it_is_copied_and_filled_tensor_by_tensor() {
    let network = config().init(7, &Device::flex()).unwrap();
    let mut values = read(&network).into_iter();
    let zeros = fill(network.clone(), |slot| vec![0.0; slot.shape.iter().product()]);
    assert!(read(&zeros).iter().all(|(_, values)| values.iter().all(|value| *value == 0.0)));
    let copy = fill(zeros, |_| values.next().unwrap().1);
    let output = |network: &HandRegressor| {
        let output = network.forward(Tensor::from_data(images(1), &Device::flex()));
        output.into_data().iter::<f32>().collect::<Vec<_>>()
    };
    assert_eq!(output(&copy), output(&network));
}

#[test]
fn a_width_below_its_own_limit_is_refused() {
    let narrow = HandRegressorConfig { width: 0.01, ..config() };
    assert!(matches!(narrow.init(7, &Device::flex()), Err(NnError::Width { .. })));
    let unknown = HandRegressorConfig { backbone: "double".to_owned(), ..config() };
    let error = unknown.init(7, &Device::flex()).map(|_| ()).unwrap_err().to_string();
    assert!(error.ends_with("inception_v3, single"), "{error}");
}
