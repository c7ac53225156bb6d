//! Training is reproducible to the bit, also across a checkpoint.

use burn::optim::{AdamConfig, GradientsParams, ModuleOptimizer};
use burn::tensor::Device;
use evpose_nn::parameters::read;
use evpose_nn::weights::{ModelCard, load, save};
use evpose_nn::{HandLoss, HandRegressor};

use crate::golden::{images, small, targets};

fn step(network: HandRegressor, adam: &mut ModuleOptimizer, device: &Device) -> HandRegressor {
    let outputs = network.forward(images(4, 36, 48, device));
    let loss = HandLoss::default().forward(outputs, targets(4, device)).objective;
    let gradients = GradientsParams::from_grads(loss.backward(), &network);
    adam.step(1e-3, network, gradients)
}

#[test]
fn two_runs_from_one_seed_are_equal_to_the_bit() {
    let device = Device::flex().autodiff();
    let run = || {
        let mut adam = AdamConfig::new().init();
        let mut network = small().init(3, &device).unwrap();
        for _ in 0..3 {
            network = step(network, &mut adam, &device);
        }
        read(&network)
    };
    assert!(run() == run());
}

#[test]
fn a_network_trains_on_from_its_checkpoint_as_if_nothing_had_happened() {
    let device = Device::flex().autodiff();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hand.bpk");
    let mut adam = AdamConfig::new().init();
    let mut network = small().init(3, &device).unwrap();
    for _ in 0..2 {
        network = step(network, &mut adam, &device);
    }
    save(&path, &network, &ModelCard::default()).unwrap();
    // The optimiser finds its moments again because parameters are identified by their paths.
    let mut adam_resumed = adam.clone();
    let (mut resumed, _) = load(&path, &device).unwrap();
    for _ in 0..2 {
        network = step(network, &mut adam, &device);
        resumed = step(resumed, &mut adam_resumed, &device);
    }
    assert!(read(&network) == read(&resumed));
}
