//! Golden values of PyTorch, and the closed forms they were computed from; see `tests/data/README.md`.

#![allow(clippy::unwrap_used, dead_code, reason = "tests, each of which uses a part")]

use std::collections::BTreeMap;
use std::io::Read;
use std::path::PathBuf;

use burn::module::{Module, ModuleVisitor, Param, ParamId};
use burn::tensor::{Device, Tensor, TensorData};
use evpose_nn::HandRegressorConfig;
use evpose_nn::parameters::Slot;
use serde::Deserialize;

/// `golden.json`.
#[derive(Deserialize)]
pub(crate) struct Golden {
    /// Outputs of the checkpoints by image size.
    pub(crate) checkpoint: BTreeMap<String, Vec<f32>>,
    /// Outputs of the bare `state_dict`.
    pub(crate) state_dict: Vec<f32>,
    /// Outputs of networks with closed-form weights, by backbone.
    pub(crate) formula: BTreeMap<String, Vec<f32>>,
    /// Outputs of the VGG among them for images that end as 2 x 3 pixels.
    pub(crate) pooled: Vec<f32>,
    /// One step of training from the same weights, by backbone.
    pub(crate) gradient: BTreeMap<String, GradientGolden>,
    /// The loss of `targets(5) / 2 + 0.01` for `targets(5)`.
    pub(crate) loss: LossGolden,
    /// Four steps of Adam from the checkpoint.
    pub(crate) training: TrainingGolden,
}

#[derive(Deserialize)]
pub(crate) struct LossGolden {
    pub(crate) total: f32,
    pub(crate) objective: f32,
    pub(crate) articulation: f32,
    pub(crate) translation_m2: f32,
    pub(crate) depth_m2: f32,
    pub(crate) rotation_rad2: f32,
    pub(crate) gradient: Vec<f32>,
}

#[derive(Deserialize)]
pub(crate) struct GradientGolden {
    pub(crate) objective: f32,
    /// By the weight of the first convolution.
    pub(crate) conv1_weight: Vec<f32>,
}

#[derive(Deserialize)]
pub(crate) struct TrainingGolden {
    pub(crate) objective: Vec<f32>,
    pub(crate) bn1_running_mean: Vec<f32>,
}

pub(crate) fn golden() -> Golden {
    serde_json::from_slice(&std::fs::read(data("golden.json")).unwrap()).unwrap()
}

pub(crate) fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// A file of a zip archive, unpacked into a directory that lives as long as the result.
pub(crate) fn unpacked(archive: &str, name: &str) -> (tempfile::TempDir, PathBuf) {
    let archive = std::fs::File::open(data(archive)).unwrap();
    let mut bytes = Vec::new();
    zip::ZipArchive::new(archive).unwrap().by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

/// The network of the committed checkpoints.
pub(crate) fn small() -> HandRegressorConfig {
    HandRegressorConfig {
        backbone: "resnet18".to_owned(),
        width: 0.0625,
        ..HandRegressorConfig::default()
    }
}

/// `count` values in [0, 1): the fraction of `43758.5453 sin(12.9898 i + 78.233 stream)`.
pub(crate) fn hashed(count: usize, stream: usize) -> Vec<f64> {
    let value = |i: usize| (12.9898 * i as f64 + 78.233 * stream as f64).sin() * 43758.5453;
    (0..count).map(|i| value(i) - value(i).floor()).collect()
}

/// Half of the pixels zero, the others between 0.5 and 1.
pub(crate) fn images(batch: usize, height: usize, width: usize, device: &Device) -> Tensor<4> {
    let shape = [batch, 2, height, width];
    let values = hashed(shape.iter().product(), 1000).into_iter();
    let values = values.map(|u| if u > 0.5 { u as f32 } else { 0.0 }).collect();
    Tensor::from_data(TensorData::new(values, shape), device)
}

/// Half of the values zero, the others between 127.5 and 255.
pub(crate) fn bright_images(shape: [usize; 4], device: &Device) -> Tensor<4> {
    let values = hashed(shape.iter().product(), 1000).into_iter();
    let values = values.map(|u| if u > 0.5 { (255.0 * u) as f32 } else { 0.0 }).collect();
    Tensor::from_data(TensorData::new(values, shape), device)
}

/// The values of the tensor at `position` in PyTorch's order of tensors.
pub(crate) fn closed_form(slot: &Slot, position: usize) -> Vec<f32> {
    let count = slot.shape.iter().product();
    let centred = hashed(count, position).into_iter().map(|u| u - 0.5);
    let affine = |offset: f64, scale: f64| {
        centred.clone().map(|u| (offset + scale * u) as f32).collect::<Vec<_>>()
    };
    match (slot.name(), slot.shape.as_slice()) {
        ("weight", &[_, channels, ky, kx]) => {
            // `u` has a deviation of 1 / sqrt(12): the weights have that of He's initialisation.
            affine(0.0, 12f64.sqrt() * (2.0 / (channels * ky * kx) as f64).sqrt())
        }
        ("weight", &[inputs, outputs]) => {
            // PyTorch counts linear weights by outputs, Burn stores them by inputs.
            let rows = affine(0.0, 0.2);
            (0..count).map(|i| rows[i % outputs * inputs + i / outputs]).collect()
        }
        ("running_var", _) => affine(1.0, 0.5),
        ("gamma", _) => affine(0.6, 0.5),
        _ => affine(0.0, 0.2),
    }
}

/// Values of a map at every 7919th pixel, modulo all of them.
pub(crate) fn sampled(map: &[f32], count: usize) -> Vec<f32> {
    (0..count).map(|k| map[k * 7919 % map.len()]).collect()
}

/// Uniform within 0.5, translations within 0.05.
pub(crate) fn targets(batch: usize, device: &Device) -> Tensor<2> {
    let values = hashed(batch * 12, 2000).into_iter().enumerate();
    let scale = |i: usize| if (6..9).contains(&(i % 12)) { 0.1 } else { 1.0 };
    let values = values.map(|(i, u)| ((u - 0.5) * scale(i)) as f32).collect();
    Tensor::from_data(TensorData::new(values, [batch, 12]), device)
}

/// The largest difference.
pub(crate) fn worst(ours: &[f32], theirs: &[f32]) -> f32 {
    assert_eq!(ours.len(), theirs.len());
    ours.iter().zip(theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

pub(crate) fn values<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    tensor.into_data().iter().collect()
}

/// The first parameter of a network: the weight of its first convolution.
pub(crate) fn first_id(network: &impl Module) -> ParamId {
    struct First(Option<ParamId>);
    impl ModuleVisitor for First {
        fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
            self.0.get_or_insert(param.id);
        }
    }
    let mut first = First(None);
    network.visit(&mut first);
    first.0.unwrap()
}
