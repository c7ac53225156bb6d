//! Outputs and gradients of networks on a device, beside those of the CPU.

use anyhow::Result;
use burn::module::{Module, ModuleVisitor, Param};
use burn::tensor::{Device, Gradients, Tensor, TensorData};
use evpose_cli::latency::windows;
use evpose_cli::progress::say;
use evpose_nn::parameters::away_from_kinks;
use evpose_nn::{DeviceKind, HandLoss, Network, adapter_name};
use serde::Serialize;

/// Networks that have every kind of layer between them.
const NETWORKS: [&str; 3] = ["resnet18", "move_enet", "mobilenet_v2"];
const WIDTH: f32 = 0.25;
const BATCH: usize = 3;
const SIDE_PX: usize = 64;
/// Of networks and images.
const SEED: u64 = 3;

/// Content of the JSON file.
#[derive(Debug, Serialize)]
pub(super) struct Agreement {
    device: String,
    adapter: Option<String>,
    networks: Vec<Differences>,
}

/// Largest differences, relative to the largest value, at least 1 for outputs and objectives.
#[derive(Debug, Serialize)]
struct Differences {
    network: &'static str,
    outputs: f64,
    objective: f64,
    gradients: f64,
    /// Norm of the difference of all gradients over the norm of the CPU's.
    gradients_norm: f64,
}

pub(super) fn measure(kind: DeviceKind) -> Result<Agreement> {
    let (gpu, cpu) = (kind.resolve()?, Device::flex());
    let mut agreement =
        Agreement { device: kind.to_string(), adapter: adapter_name(&gpu), networks: Vec::new() };
    for network in NETWORKS {
        let differences = differences(network, &gpu, &cpu)?;
        say(format!("{differences:?}"));
        agreement.networks.push(differences);
    }
    Ok(agreement)
}

fn differences(network: &'static str, gpu: &Device, cpu: &Device) -> Result<Differences> {
    // Relative to 1, the scale of outputs, since some are near 0.
    let outputs = largest_difference(&outputs(network, gpu)?, &outputs(network, cpu)?, 1.0);
    let ([objective, gradients], [objective_cpu, gradients_cpu]) =
        (step(network, gpu)?, step(network, cpu)?);
    Ok(Differences {
        network,
        outputs,
        objective: largest_difference(&objective, &objective_cpu, 1.0),
        gradients: largest_difference(&gradients, &gradients_cpu, 0.0),
        // One number for all: single gradients near 0 differ by any factor.
        gradients_norm: norm(&minus(&gradients, &gradients_cpu)) / norm(&gradients_cpu),
    })
}

fn images(network: &Network, device: &Device) -> Tensor<4> {
    let size = [BATCH, network.input()[0], SIDE_PX, SIDE_PX];
    let values = windows(size, SEED).into_iter();
    let values = values.map(|u| if u > 0.5 { u * network.max_input() } else { 0.0 });
    Tensor::from_data(TensorData::new(values.collect::<Vec<f32>>(), size), device)
}

fn outputs(name: &str, device: &Device) -> Result<Vec<f64>> {
    // With initial variances of 1, activations vanish with depth, and any two devices agree.
    let network = Network::untrained(name, WIDTH, SEED, device)?.with_matched_variances();
    Ok(network.outputs(images(&network, device)).concat().into_iter().map(f64::from).collect())
}

/// The objective of a training step, and the gradients of all parameters.
fn step(name: &str, device: &Device) -> Result<[Vec<f64>; 2]> {
    let device = &device.clone().autodiff();
    let network = Network::untrained(name, WIDTH, SEED, device)?;
    let images = images(&network, device);
    Ok(match network {
        Network::Hand(network) => {
            let network = away_from_kinks(*network);
            let outputs = network.forward(images);
            // Targets differ from the images: equal values would be a special case.
            let targets = windows([BATCH, outputs.dims()[1], 1, 1], SEED ^ 1);
            let targets = TensorData::new(targets, outputs.dims());
            let targets = Tensor::from_data(targets, device);
            gradients(&network, HandLoss::default().forward(outputs, targets).objective)
        }
        Network::Body(network) => {
            let network = away_from_kinks(*network);
            let squares = network.forward(images).into_array().map(|map| map.square().mean());
            let sum = squares.into_iter().reduce(|sum, square| sum + square);
            gradients(&network, sum.unwrap_or_else(|| unreachable!("four maps")))
        }
        Network::Joints(network) => {
            let network = away_from_kinks(*network);
            gradients(&network, network.forward(images).into_rows().square().mean())
        }
    })
}

fn gradients<M: Module>(network: &M, objective: Tensor<1>) -> [Vec<f64>; 2] {
    let gradients = objective.backward();
    let mut flattened = Flattened { gradients: &gradients, list: Vec::new() };
    network.visit(&mut flattened);
    [values(objective), flattened.list]
}

/// Gradients of all trained parameters.
struct Flattened<'a> {
    gradients: &'a Gradients,
    list: Vec<f64>,
}

impl ModuleVisitor for Flattened<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        if let Some(gradient) = param.val().grad(self.gradients) {
            self.list.extend(values(gradient));
        }
    }
}

fn values<const D: usize>(tensor: Tensor<D>) -> Vec<f64> {
    tensor.into_data().iter::<f64>().collect()
}

fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}

fn largest(values: &[f64]) -> f64 {
    // A value that is no number counts as the largest.
    let magnitudes =
        values.iter().map(|value| if value.is_nan() { f64::INFINITY } else { value.abs() });
    magnitudes.fold(0.0, f64::max)
}

/// The largest difference, relative to the largest value of `b`, at least `least`.
fn largest_difference(a: &[f64], b: &[f64], least: f64) -> f64 {
    largest(&minus(a, b)) / largest(b).max(least)
}
