//! The networks that MoveEnet is compared with, against PyTorch; see `tests/data/README.md`.

#![allow(clippy::unwrap_used, reason = "tests")]

mod golden;

use std::io::Read;
use std::path::PathBuf;

use burn::module::Module;
use burn::optim::GradientsParams;
use burn::tensor::{Device, Tensor, TensorData};
use evpose_nn::parameters::{Slot, fill, read, slots};
#[cfg(feature = "hdf5")]
use evpose_nn::weights::load_dhp19_cnn;
use evpose_nn::weights::load_lift_mono;
use evpose_nn::{
    Dhp19CnnConfig, LiftMono, LiftMonoConfig, MarginalTargets, NnError, marginal_loss,
};
use golden::{data, first_id, hashed, values, worst};
use serde::Deserialize;

const TOLERANCE: f32 = 1e-4;
/// Pixels between sampled values, modulo all values of an output.
const STRIDE: usize = 7919;

/// `baselines.json`.
#[derive(Deserialize)]
struct Golden {
    dhp19_cnn: Map,
    dhp19_training: HeatmapTraining,
    distributed: Map,
    tiny: Map,
    lift_mono: Vec<Lift>,
    lift_mono_training: LiftTraining,
    lift_mono_parameters: usize,
    lift_mono_tiny: Vec<f32>,
}

#[derive(Deserialize)]
struct Map {
    /// Of absolute values.
    mean: f32,
    sampled: Vec<f32>,
    /// The largest value of each joint.
    #[serde(default)]
    peaks: Vec<f32>,
}

#[derive(Deserialize)]
struct Lift {
    stages: usize,
    joints: usize,
    divisor: usize,
    images: [usize; 4],
    /// For each stage, those of the three planes.
    maps: Vec<[Map; 3]>,
    positions: Vec<f32>,
}

#[derive(Deserialize)]
struct LiftTraining {
    total: f32,
    distance: f32,
    divergence: f32,
    stem_gradient: Vec<f32>,
    running_mean: Vec<f32>,
}

#[derive(Deserialize)]
struct HeatmapTraining {
    loss: f32,
    gradient: Vec<f32>,
}

fn golden() -> Golden {
    serde_json::from_slice(&std::fs::read(data("baselines.json")).unwrap()).unwrap()
}

/// A file of `baselines.zip`, unpacked into a directory that lives as long as the result.
fn unpacked(name: &str) -> (tempfile::TempDir, PathBuf) {
    let archive = std::fs::File::open(data("baselines.zip")).unwrap();
    let mut bytes = Vec::new();
    zip::ZipArchive::new(archive).unwrap().by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

/// Half of the values zero, the others between 127.5 and 255.
fn images(shape: [usize; 4], device: &Device) -> Tensor<4> {
    let values = hashed(shape.iter().product(), 1000).into_iter();
    let values: Vec<f32> = values.map(|u| if u > 0.5 { (255.0 * u) as f32 } else { 0.0 }).collect();
    Tensor::from_data(TensorData::new(values, shape), device)
}

/// Every tensor by the closed form of its position.
fn closed<M: Module>(network: M) -> M {
    let mut position = 0;
    fill(network, |slot: &Slot| {
        let centred: Vec<f64> =
            hashed(slot.shape.iter().product(), position).into_iter().map(|u| u - 0.5).collect();
        position += 1;
        let affine = |offset: f64, scale: f64| {
            centred.iter().map(|u| (offset + scale * u) as f32).collect::<Vec<_>>()
        };
        match (slot.name(), slot.shape.as_slice()) {
            ("weight", &[_, channels, rows, columns]) => {
                affine(0.0, 12f64.sqrt() * (2.0 / (channels * rows * columns) as f64).sqrt())
            }
            ("running_var", _) => affine(1.0, 0.5),
            ("gamma", _) => affine(0.6, 0.5),
            _ => affine(0.0, 0.2),
        }
    })
}

/// Compares maps with sampled values, relative to `scale`.
fn assert_sampled(maps: Tensor<4>, expected: &Map, scale: f32, context: &str) {
    let ours = values(maps);
    let mean = ours.iter().map(|value| f64::from(value.abs())).sum::<f64>() / ours.len() as f64;
    assert!((mean as f32 - expected.mean).abs() < TOLERANCE * scale, "{context}: mean {mean}");
    let sampled: Vec<f32> = (0..24).map(|k| ours[k * STRIDE % ours.len()]).collect();
    let worst = worst(&sampled, &expected.sampled);
    assert!(worst < TOLERANCE * scale, "{context}: {worst}");
}

#[test]
fn the_network_of_dhp19_computes_what_pytorch_computes() {
    let device = Device::flex();
    let network = closed(Dhp19CnnConfig::default().init(0, &device).unwrap());
    let maps = network.forward(images([2, 1, 28, 36], &device));
    // Values up to a hundred.
    assert_sampled(maps, &golden().dhp19_cnn, 10.0, "closed form");
}

#[test]
fn the_network_of_dhp19_has_the_gradient_of_pytorch() {
    let device = Device::flex().autodiff();
    let network = closed(Dhp19CnnConfig { joints: 3, width: 0.25 }.init(0, &device).unwrap());
    let maps = network.forward(images([2, 1, 20, 28], &device));
    let shape = maps.dims();
    let targets: Vec<f32> =
        hashed(shape.iter().product(), 2000).into_iter().map(|u| u as f32).collect();
    let targets = Tensor::<4>::from_data(TensorData::new(targets, shape), &device);
    let loss = (maps - targets).square().mean();
    let expected = golden().dhp19_training;
    let relative = loss.clone().into_scalar::<f32>() / expected.loss - 1.0;
    assert!(relative.abs() < TOLERANCE, "{relative}");
    let gradients = GradientsParams::from_grads(loss.backward(), &network);
    let gradient = values(gradients.get::<4>(first_id(&network)).unwrap());
    let largest = expected.gradient.iter().fold(0.0f32, |a, b| a.max(b.abs()));
    let error = worst(&gradient, &expected.gradient) / largest;
    assert!(error < TOLERANCE, "{error}");
}

#[cfg(feature = "hdf5")]
#[test]
fn weights_that_keras_wrote_are_read_and_joints_brought_into_our_order() {
    let device = Device::flex();
    let (_folder, path) = unpacked("DHP_CNN.model");
    let config = Dhp19CnnConfig { joints: 13, width: 0.0625 };
    let network = load_dhp19_cnn(&path, &config, &device).unwrap();
    let maps = network.forward(images([1, 1, 16, 20], &device) / 255.0);
    assert_sampled(maps, &golden().tiny, 1e4, "as written by Keras");

    let error = load_dhp19_cnn(&path, &Dhp19CnnConfig::default(), &device).unwrap_err();
    let NnError::Mismatch { mismatch, .. } = &error else { panic!("{error}") };
    let conv1 = ("conv1".to_owned(), vec![3, 3, 1, 16], vec![3, 3, 1, 1]);
    assert!(mismatch.reshaped.contains(&conv1), "{error}");
    std::fs::write(&path, "GIF89a").unwrap();
    let error = load_dhp19_cnn(&path, &config, &device).unwrap_err();
    assert!(matches!(error, NnError::Unreadable { format: "Keras", .. }), "{error}");
}

/// Reads `DHP_CNN.model` of <https://github.com/SensorsINI/DHP19> at `EVPOSE_DHP19_CNN`.
#[cfg(feature = "hdf5")]
#[test]
#[ignore = "needs the file of the distributed weights: EVPOSE_DHP19_CNN=DHP_CNN.model"]
fn the_distributed_weights_give_the_heatmaps_of_the_keras_graph() {
    let device = Device::flex();
    let path = PathBuf::from(std::env::var_os("EVPOSE_DHP19_CNN").unwrap());
    let network = load_dhp19_cnn(&path, &Dhp19CnnConfig::default(), &device).unwrap();
    let maps = network.forward(images([1, 1, 260, 344], &device));
    let peaks = values(maps.clone().reshape([1, 13, 260 * 344]).max_dim(2));
    let expected = golden().distributed;
    assert!(worst(&peaks, &expected.peaks) < TOLERANCE, "{peaks:?}");
    assert_sampled(maps, &expected, 1.0, "distributed");
}

fn lift(lift: &Lift, device: &Device) -> LiftMono {
    let config = LiftMonoConfig {
        joints: lift.joints,
        width: 1.0 / lift.divisor as f32,
        stages: lift.stages,
    };
    closed(config.init(0, device).unwrap())
}

#[test]
fn lift_mono_computes_what_pytorch_computes() {
    let device = Device::flex();
    for expected in golden().lift_mono {
        let stages = lift(&expected, &device).forward(images(expected.images, &device));
        assert_eq!(stages.len(), expected.maps.len());
        let positions = values(stages.last().unwrap().positions());
        let worst = worst(&positions, &expected.positions);
        assert!(worst < TOLERANCE, "1/{}: {worst}", expected.divisor);
        for (maps, want) in stages.into_iter().zip(&expected.maps) {
            for (map, want) in maps.into_array().into_iter().zip(want) {
                assert_sampled(map, want, 1.0, "plane");
            }
        }
    }
}

#[test]
fn the_loss_of_lift_mono_and_its_gradient_are_those_of_pytorch() {
    let device = Device::flex().autodiff();
    let config = LiftMonoConfig { joints: 3, width: 0.125, stages: 2 };
    let network = closed(config.init(0, &device).unwrap());
    let stages = network.forward(images([4, 1, 52, 72], &device));
    let positions: Vec<f32> = hashed(36, 2000).into_iter().map(|u| (u - 0.5) as f32).collect();
    let known = vec![1.0f32, 1.0, 0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0];
    let targets = MarginalTargets {
        positions: Tensor::from_data(TensorData::new(positions, [4, 3, 3]), &device),
        known: Tensor::from_data(TensorData::new(known, [4, 3]), &device),
    };
    let parts = marginal_loss(&stages, &targets, 1.0);
    let expected = golden().lift_mono_training;
    for (ours, theirs) in [
        (parts.total.clone(), expected.total),
        (parts.distance, expected.distance),
        (parts.divergence, expected.divergence),
    ] {
        let ours = ours.into_scalar::<f32>();
        assert!((ours - theirs).abs() < TOLERANCE, "{ours} {theirs}");
    }
    let gradients = GradientsParams::from_grads(parts.total.backward(), &network);
    let gradient = values(gradients.get::<4>(first_id(&network)).unwrap());
    let largest = expected.stem_gradient.iter().fold(0.0f32, |a, b| a.max(b.abs()));
    // Golden values are of double precision; seventy normalisations amplify rounding.
    let error = worst(&gradient, &expected.stem_gradient) / largest;
    assert!(error < 0.01, "{error}");
    let tensors = read(&network.valid());
    let mean = tensors
        .iter()
        .find(|(slot, _)| slot.path == "combiners.0.first.norm.running_mean")
        .unwrap();
    assert!(worst(&mean.1, &expected.running_mean) < TOLERANCE);
}

#[test]
fn tensors_of_lift_mono_have_the_names_of_the_published_code() {
    let device = Device::flex();
    let (_folder, path) = unpacked("lift_mono_names.txt");
    let text = std::fs::read_to_string(path).unwrap();
    let config = LiftMonoConfig { joints: 3, width: 0.125, stages: 2 };
    let network = config.init(0, &device).unwrap();
    let ours: Vec<String> = slots(&network)
        .iter()
        .map(|slot| {
            let shape: Vec<String> = slot.shape.iter().map(ToString::to_string).collect();
            format!("{} {}", network.pytorch_name(slot), shape.join("x"))
        })
        .collect();
    assert_eq!(ours, text.lines().collect::<Vec<_>>());
    let count = LiftMonoConfig::default().parameter_count().unwrap();
    assert_eq!(count, golden().lift_mono_parameters);
}

#[test]
fn checkpoints_of_lift_mono_are_read_and_joints_brought_into_our_order() {
    let device = Device::flex();
    let (_folder, path) = unpacked("lift_mono.ckpt");
    let config = LiftMonoConfig { joints: 13, width: 1.0 / 64.0, stages: 2 };
    let network = load_lift_mono(&path, &config, &device).unwrap();
    let stages = network.forward(images([1, 1, 40, 48], &device));
    let positions = values(stages[1].positions());
    let worst = worst(&positions, &golden().lift_mono_tiny);
    assert!(worst < TOLERANCE, "{worst}");
    let error = load_lift_mono(&path, &LiftMonoConfig::default(), &device).unwrap_err();
    assert!(matches!(error, NnError::Mismatch { .. }), "{error}");
}
