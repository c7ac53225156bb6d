//! The networks that MoveEnet is compared with, against PyTorch; see `tests/data/README.md`.

#[cfg(feature = "hdf5")]
use std::path::PathBuf;

use burn::module::Module;
use burn::optim::GradientsParams;
use burn::tensor::{Device, Tensor, TensorData};
use evpose_nn::parameters::{fill, read, slots, trained_count};

use crate::golden::{
    bright_images, closed_form, data, first_id, hashed, sampled, unpacked, values, worst,
};
#[cfg(feature = "hdf5")]
use evpose_nn::weights::load_dhp19_cnn;
use evpose_nn::weights::load_lift_mono;
use evpose_nn::{
    Dhp19CnnConfig, LiftMono, LiftMonoConfig, MarginalTargets, NnError, marginal_loss,
};
use serde::Deserialize;

const TOLERANCE: f32 = 1e-4;
/// The archive of committed weights and names.
const ARCHIVE: &str = "baselines.zip";

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

/// Every tensor by the closed form of its position.
fn closed<M: Module>(network: M) -> M {
    let mut position = 0;
    fill(network, |slot| {
        position += 1;
        closed_form(slot, position - 1)
    })
}

/// Compares maps with sampled values, relative to `scale`.
fn assert_sampled(maps: Tensor<4>, expected: &Map, scale: f32, context: &str) {
    let ours = values(maps);
    let mean = ours.iter().map(|value| f64::from(value.abs())).sum::<f64>() / ours.len() as f64;
    assert!((mean as f32 - expected.mean).abs() < TOLERANCE * scale, "{context}: mean {mean}");
    let worst = worst(&sampled(&ours, 24), &expected.sampled);
    assert!(worst < TOLERANCE * scale, "{context}: {worst}");
}

#[test]
fn the_network_of_dhp19_computes_what_pytorch_computes() {
    let device = Device::flex();
    let network = closed(Dhp19CnnConfig::default().init(0, &device).unwrap());
    let maps = network.forward(bright_images([2, 1, 28, 36], &device));
    // Values up to a hundred.
    assert_sampled(maps, &golden().dhp19_cnn, 10.0, "closed form");
}

#[test]
fn the_network_of_dhp19_has_the_gradient_of_pytorch() {
    let device = Device::flex().autodiff();
    let network = closed(Dhp19CnnConfig { joints: 3, width: 0.25 }.init(0, &device).unwrap());
    let maps = network.forward(bright_images([2, 1, 20, 28], &device));
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
    let (_folder, path) = unpacked(ARCHIVE, "DHP_CNN.model");
    let config = Dhp19CnnConfig { joints: 13, width: 0.0625 };
    let network = load_dhp19_cnn(&path, &config, &device).unwrap();
    let maps = network.forward(bright_images([1, 1, 16, 20], &device) / 255.0);
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
    let maps = network.forward(bright_images([1, 1, 260, 344], &device));
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
        let stages = lift(&expected, &device).forward(bright_images(expected.images, &device));
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
    let stages = network.forward(bright_images([4, 1, 52, 72], &device));
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
    let (_folder, path) = unpacked(ARCHIVE, "lift_mono_names.txt");
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
    let published = LiftMonoConfig::default().init(0, &device).unwrap();
    assert_eq!(trained_count(&published), golden().lift_mono_parameters);
}

#[test]
fn checkpoints_of_lift_mono_are_read_and_joints_brought_into_our_order() {
    let device = Device::flex();
    let (_folder, path) = unpacked(ARCHIVE, "lift_mono.ckpt");
    let config = LiftMonoConfig { joints: 13, width: 1.0 / 64.0, stages: 2 };
    let network = load_lift_mono(&path, &config, &device).unwrap();
    let stages = network.forward(bright_images([1, 1, 40, 48], &device));
    let positions = values(stages[1].positions());
    let worst = worst(&positions, &golden().lift_mono_tiny);
    assert!(worst < TOLERANCE, "{worst}");
    let error = load_lift_mono(&path, &LiftMonoConfig::default(), &device).unwrap_err();
    assert!(matches!(error, NnError::Mismatch { .. }), "{error}");
}
