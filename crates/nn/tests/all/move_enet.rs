//! The MoveEnet network against PyTorch; see `tests/data/README.md`.

use burn::module::Module;
use burn::optim::GradientsParams;
use burn::tensor::Device;
use evpose_nn::parameters::{fill, read, slots};
use evpose_nn::weights::load_move_enet;
use evpose_nn::{MoveEnet, MoveEnetConfig, NnError};
use serde::Deserialize;

use crate::golden::{bright_images, closed_form, data, sampled, unpacked, values, worst};

const TOLERANCE: f32 = 1e-4;

/// `move_enet.json`.
#[derive(Deserialize)]
struct Golden {
    networks: Vec<Network>,
    training: Training,
    /// Of the checkpoints, for an image of 64x32.
    checkpoint: Vec<Map>,
}

#[derive(Deserialize)]
struct Network {
    joints: usize,
    width: f32,
    expansion: usize,
    images: [usize; 4],
    maps: Vec<Map>,
}

#[derive(Deserialize)]
struct Map {
    /// Of absolute values.
    mean: f64,
    sampled: Vec<f32>,
}

#[derive(Deserialize)]
struct Training {
    loss: f32,
    stem_gradient: Vec<f32>,
    repeated_mean: Vec<f32>,
}

fn golden() -> Golden {
    serde_json::from_slice(&std::fs::read(data("move_enet.json")).unwrap()).unwrap()
}

/// A network whose weights are closed forms of their position among all names of PyTorch, sorted.
fn formula(config: &MoveEnetConfig, device: &Device) -> MoveEnet {
    let network = config.init(0, device).unwrap();
    let names: Vec<_> = slots(&network).iter().map(|slot| network.pytorch_name(slot)).collect();
    let mut sorted = names.clone();
    sorted.sort();
    let position = |name| sorted.binary_search(name).unwrap();
    let mut positions = names.iter().map(position);
    fill(network, |slot| closed_form(slot, positions.next().unwrap()))
}

/// Compares the four maps of `network` with those of PyTorch.
fn assert_maps(network: &MoveEnet, shape: [usize; 4], expected: &[Map], what: &str) {
    let maps = network.forward(bright_images(shape, &Device::flex())).into_array();
    assert_eq!(expected.len(), maps.len());
    for (map, expected) in maps.into_iter().zip(expected) {
        let ours = values(map);
        let worst = worst(&sampled(&ours, expected.sampled.len()), &expected.sampled);
        assert!(worst < TOLERANCE, "{what}: {worst}");
        let sum: f64 = ours.iter().map(|value| f64::from(value.abs())).sum();
        let difference = (sum / ours.len() as f64 - expected.mean).abs();
        assert!(difference < f64::from(TOLERANCE), "{what}: {difference}");
    }
}

#[test]
fn every_map_is_that_of_pytorch() {
    let device = Device::flex();
    let golden = golden();
    assert_eq!(golden.networks.len(), 4);
    for Network { joints, width, expansion, images, maps } in golden.networks {
        let config = MoveEnetConfig { joints, width, expansion };
        let network = formula(&config, &device);
        assert_maps(&network, images, &maps, &format!("{config:?} {images:?}"));
    }
}

#[test]
fn training_has_the_gradient_and_the_statistics_of_pytorch() {
    let device = Device::flex().autodiff();
    let expected = golden().training;
    let network = formula(&MoveEnetConfig { width: 0.1, ..MoveEnetConfig::default() }, &device);
    let maps = network.forward(bright_images([4, 3, 96, 96], &device)).into_array();
    let losses = maps.into_iter().map(|map| map.powi_scalar(2).mean());
    let loss = losses.reduce(|sum, loss| sum + loss).unwrap();
    let difference = (loss.clone().into_scalar::<f32>() - expected.loss).abs();
    assert!(difference < TOLERANCE, "{difference}");
    // The first parameter is the weight of the stem.
    let gradients = GradientsParams::from_grads(loss.backward(), &network);
    let gradient = values(gradients.get::<4>(crate::golden::first_id(&network)).unwrap());
    let largest = expected.stem_gradient.iter().fold(0.0_f32, |most, value| most.max(value.abs()));
    let error = worst(&gradient, &expected.stem_gradient) / largest;
    assert!(error < 1e-3, "{error}");
    // Three passes in one step, each of which moves it.
    let statistics = read(&network.valid());
    let path = "backbone.stages.2.repeated.expand.norm.running_mean";
    let mean = &statistics.iter().find(|(slot, _)| slot.path == path).unwrap().1;
    assert!(worst(mean, &expected.repeated_mean) < 1e-5);
}

/// The network of the committed checkpoints.
fn tiny() -> MoveEnetConfig {
    MoveEnetConfig { joints: 2, width: 0.01, expansion: 1 }
}

/// The archive of the committed checkpoints.
const CHECKPOINTS: &str = "move_enet_tiny.zip";
/// The containers of `torch.save` in it.
const CONTAINERS: [&str; 2] = ["zip.pth", "legacy.pth"];

#[test]
fn both_containers_of_pytorch_are_read() {
    let read_one = |name| {
        let (_folder, path) = unpacked(CHECKPOINTS, name);
        let network = load_move_enet(&path, &tiny(), &Device::flex()).unwrap();
        assert_maps(&network, [1, 3, 64, 32], &golden().checkpoint, name);
        read(&network)
    };
    let [zip, legacy] = CONTAINERS.map(read_one);
    assert!(zip == legacy);
}

#[test]
fn weights_of_another_network_are_named() {
    let (_folder, path) = unpacked(CHECKPOINTS, "zip.pth");
    let error = |config| load_move_enet(&path, &config, &Device::flex()).map(|_| ()).unwrap_err();
    let more = error(MoveEnetConfig { joints: 3, ..tiny() });
    let NnError::Mismatch { mismatch, .. } = &more else { panic!("{more}") };
    let heatmaps = ("header.header_heatmaps.1.bias".to_owned(), vec![3], vec![2]);
    assert!(mismatch.reshaped.contains(&heatmaps), "{more}");
    assert_eq!(mismatch.reshaped.len(), 6, "{more}");
    // Names are the same bytes in the pickle, which has no checksum when it lies bare.
    let (_folder, path) = unpacked(CHECKPOINTS, "legacy.pth");
    let mut bytes = std::fs::read(&path).unwrap();
    let name = b"backbone.features4.2.conv2.3.weight";
    let at = bytes.windows(name.len()).position(|window| window == name).unwrap();
    bytes[at + "backbone.features4.2.".len()] = b'k';
    std::fs::write(&path, bytes).unwrap();
    let renamed = load_move_enet(&path, &tiny(), &Device::flex()).map(|_| ()).unwrap_err();
    let NnError::Mismatch { mismatch, .. } = &renamed else { panic!("{renamed}") };
    assert_eq!(mismatch.missing, ["backbone.features4.2.conv2.3.weight"]);
    assert_eq!(mismatch.unexpected, ["backbone.features4.2.konv2.3.weight"]);
}
