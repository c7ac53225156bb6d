//! Every network on wgpu: outputs and a training step, against the CPU.
//!
//! Without an adapter these tests are ignored, with the reason; Mesa's lavapipe is one on any Linux
//! machine. `cargo test -p evpose-nn --features wgpu --test wgpu` shows the differences.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

mod golden;

use std::process::ExitCode;

use burn::module::{Module, ModuleVisitor, Param};
use burn::tensor::{Device, Gradients, Tensor, TensorData};
use evpose_nn::parameters::{away_from_kinks, read};
use evpose_nn::{
    Availability, DeviceKind, HandLoss, HandRegressor, JointNet, MoveEnet, Network,
    backbone_by_name,
};
use golden::{hashed, targets};
use libtest_mimic::{Arguments, Completion, Trial};

const WGPU: DeviceKind = DeviceKind::Wgpu { adapter: None };
/// Largest difference between devices, relative to the largest value.
const TOLERANCE: f64 = 1e-3;
const BATCH: usize = 3;
const SEED: u64 = 3;
/// Seeds of a training step. A value next to the kink of a ReLU falls on either side of it by how sums were rounded, and
/// changes all gradients before it: gradients agree with one of these seeds at least, and with each where no value
/// comes near a kink.
const TRAINING_SEEDS: std::ops::Range<u64> = 3..8;

/// A test of a network on a device.
type NetworkTest = fn(&str, &Device);

/// Two tests of each network, which are ignored where there is no adapter.
fn main() -> ExitCode {
    let tests: [(&str, NetworkTest); 2] = [("infers", infers), ("trains", trains)];
    let trials = Network::names().flat_map(|network| {
        tests.map(|(verb, test)| {
            let name = format!("{network}_{verb}_as_on_the_cpu");
            Trial::ignorable_test(name, move || match WGPU.resolve() {
                Ok(device) => {
                    println!("wgpu: {:?}", Availability::of(WGPU));
                    test(network, &device);
                    Ok(Completion::Completed)
                }
                Err(error) => Ok(Completion::ignored_with(error)),
            })
        })
    });
    libtest_mimic::run(&Arguments::from_args(), trials.collect()).exit_code()
}

/// Rows and columns of the images of a network. At Inception v3's smallest, 75, its last normalisations
/// have three values a channel, and gradients of thousands follow from how they were rounded.
fn side(name: &str) -> usize {
    let smallest_px = backbone_by_name(name).map_or(0, |entry| entry.smallest_px);
    if smallest_px > 64 { smallest_px + 32 } else { 64 }
}

fn images(network: &Network, side: usize, device: &Device) -> Tensor<4> {
    let shape = [BATCH, network.input()[0], side, side];
    let values = hashed(shape.iter().product(), 1000).into_iter();
    let values = values.map(|u| if u > 0.5 { u as f32 * network.max_input() } else { 0.0 });
    Tensor::from_data(TensorData::new(values.collect::<Vec<f32>>(), shape), device)
}

fn values_of<const D: usize>(tensor: Tensor<D>) -> Vec<f64> {
    tensor.into_data().iter::<f64>().collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| largest.max(value.abs()))
}

/// The largest difference, relative to the largest value, at least `least`.
fn difference(a: &[f64], b: &[f64], least: f64) -> f64 {
    assert_eq!(a.len(), b.len());
    assert!(a.iter().chain(b).all(|value| value.is_finite()));
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    largest(&differences) / largest(b).max(least)
}

fn infers(name: &str, gpu: &Device) {
    let outputs = |device: &Device| {
        let network = Network::untrained(name, 0.125, SEED, device).unwrap();
        let network = network.with_matched_variances();
        let values = network.outputs(images(&network, side(name), device)).concat();
        values.into_iter().map(f64::from).collect::<Vec<f64>>()
    };
    let difference = difference(&outputs(gpu), &outputs(&Device::flex()), 1.0);
    println!("{name:<20} outputs {difference:.1e}");
    assert!(difference < TOLERANCE, "{name}: {difference}");
}

/// Gradients of all trained parameters.
struct Flattened<'a> {
    gradients: &'a Gradients,
    list: Vec<f64>,
}

impl ModuleVisitor for Flattened<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        if let Some(gradient) = param.val().grad(self.gradients) {
            self.list.extend(values_of(gradient));
        }
    }
}

/// Whether values come near the kinks of activations.
#[derive(Debug, Clone, Copy)]
enum Kinks {
    Near,
    Far,
}

impl Kinks {
    fn of<M: Module>(self, network: M) -> M {
        match self {
            Self::Near => network,
            Self::Far => away_from_kinks(network),
        }
    }
}

/// Objective, gradients and running statistics of a step.
fn step(name: &str, seed: u64, kinks: Kinks, device: &Device) -> [Vec<f64>; 3] {
    let device = &device.clone().autodiff();
    let network = Network::untrained(name, 0.125, seed, device).unwrap();
    let images = images(&network, side(name), device);
    match network {
        Network::Hand(network) => after_step(&kinks.of(*network), |network: &HandRegressor| {
            HandLoss::default().forward(network.forward(images), targets(BATCH, device)).objective
        }),
        Network::Body(network) => after_step(&kinks.of(*network), |network: &MoveEnet| {
            let maps = network.forward(images).into_array();
            maps.map(|map| map.square().mean()).into_iter().reduce(|sum, map| sum + map).unwrap()
        }),
        Network::Joints(network) => after_step(&kinks.of(*network), |network: &JointNet| {
            network.forward(images).into_rows().square().mean()
        }),
    }
}

fn after_step<M: Module>(network: &M, objective: impl FnOnce(&M) -> Tensor<1>) -> [Vec<f64>; 3] {
    let objective = objective(network);
    let gradients = objective.backward();
    let mut flattened = Flattened { gradients: &gradients, list: Vec::new() };
    network.visit(&mut flattened);
    let is_running = read(network).into_iter().filter(|(slot, _)| !slot.is_trained());
    let running = is_running.flat_map(|(_, values)| values).map(f64::from).collect();
    [values_of(objective), flattened.list, running]
}

/// Differences of objective, gradients and running statistics; only of gradients may they be large.
fn differences(name: &str, seed: u64, kinks: Kinks, gpu: &Device) -> [f64; 3] {
    let [ours, cpus] = [gpu, &Device::flex()].map(|device| step(name, seed, kinks, device));
    assert!(!cpus[1].is_empty() && !cpus[2].is_empty());
    // Gradients may be small as a whole.
    let differences = [0, 1, 2].map(|k| difference(&ours[k], &cpus[k], [1.0, 0.0, 1.0][k]));
    println!(
        "{name:<20} {seed} {kinks:?} objective, gradients, running statistics {differences:?}"
    );
    let [objective, _, running] = differences;
    assert!(objective < TOLERANCE && running < TOLERANCE, "{name}: {differences:?}");
    differences
}

fn trains(name: &str, gpu: &Device) {
    let is_near = |seed, kinks| differences(name, seed, kinks, gpu)[1] < TOLERANCE;
    for seed in TRAINING_SEEDS {
        assert!(is_near(seed, Kinks::Far), "{name}: gradients differ with seed {seed}");
    }
    let is_one_near = TRAINING_SEEDS.into_iter().any(|seed| is_near(seed, Kinks::Near));
    assert!(is_one_near, "{name}: gradients differ with every seed");
}
