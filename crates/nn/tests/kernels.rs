//! Training with our own kernels, and with Burn's, against training in double precision.
//!
//! One test: the switch between them holds for the whole process.

#![allow(clippy::unwrap_used, reason = "tests")]

mod golden;

use burn::module::{Module, ModuleMapper, ModuleVisitor, Param};
use burn::tensor::{DType, Device, Gradients, Tensor};
use evpose_nn::{BACKBONES, HandLoss, HandRegressorConfig, set_training_kernels};
use golden::{images, targets};

struct Flattened<'a> {
    gradients: &'a Gradients,
    found: Vec<Vec<f64>>,
}

impl ModuleVisitor for Flattened<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        if let Some(gradient) = param.val().grad(self.gradients) {
            self.found.push(numbers(gradient));
        }
    }
}

#[derive(Default)]
struct State(Vec<Vec<f64>>);

impl ModuleVisitor for State {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        self.0.push(numbers(param.val()));
    }
}

/// What computes a step.
#[derive(Debug, Clone, Copy)]
enum Arithmetic {
    Ours,
    Burns,
    /// Burn's, in double precision: the truth of the two others.
    Double,
}

struct ToDouble;

impl ModuleMapper for ToDouble {
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        param.map(|tensor| {
            let tracked = tensor.is_require_grad();
            tensor.cast(DType::F64).detach().set_require_grad(tracked)
        })
    }
}

fn numbers<const D: usize>(tensor: Tensor<D>) -> Vec<f64> {
    tensor.into_data().iter::<f64>().collect()
}

/// Output, gradients of all parameters, and the running statistics afterwards.
fn step(backbone: &str, seed: u64, arithmetic: Arithmetic) -> [Vec<Vec<f64>>; 3] {
    set_training_kernels(matches!(arithmetic, Arithmetic::Ours));
    let device = Device::flex().autodiff();
    let config = HandRegressorConfig { backbone: backbone.to_owned(), width: 0.125 };
    let mut network = config.init(seed, &device).unwrap();
    let (mut images, mut targets) = (images(6, 45, 60, &device), targets(6, &device));
    if let Arithmetic::Double = arithmetic {
        network = network.map(&mut ToDouble);
        (images, targets) = (images.cast(DType::F64), targets.cast(DType::F64));
    }
    let outputs = network.forward(images);
    let values = numbers(outputs.clone());
    let loss = HandLoss::default().forward(outputs, targets).objective;
    let gradients = loss.backward();
    let mut flattened = Flattened { gradients: &gradients, found: Vec::new() };
    network.visit(&mut flattened);
    let mut state = State::default();
    network.valid().visit(&mut state);
    [vec![values], flattened.found, state.0]
}

fn size(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |size, value| size.max(value.abs()))
}

fn error(values: &[f64], truth: &[f64]) -> f64 {
    assert_eq!(values.len(), truth.len());
    let differences = values.iter().zip(truth).map(|(a, b)| a - b);
    size(&differences.collect::<Vec<f64>>())
}

/// What is wrong with a step of our kernels, if something is.
fn fault(backbone: &str, seed: u64) -> Option<String> {
    let [ours, burns, truth] = [Arithmetic::Ours, Arithmetic::Burns, Arithmetic::Double]
        .map(|arithmetic| step(backbone, seed, arithmetic));
    for (what, ((ours, burns), truth)) in
        ["output", "gradient", "state"].iter().zip(ours.iter().zip(&burns).zip(&truth))
    {
        assert!(!truth.is_empty() && ours.len() == truth.len());
        let largest = size(&truth.concat());
        for (index, ((ours, burns), truth)) in ours.iter().zip(burns).zip(truth).enumerate() {
            // In front of a normalisation some gradients are zero but for rounding: sums of
            // thousands of terms, each of which is rounded at 1.2e-7 of the largest.
            let floor = 4.0 * f64::from(f32::EPSILON) * largest;
            let tolerance = (1e-4 * size(truth)).max(floor);
            let [ours, burns] = [ours, burns].map(|values| error(values, truth));
            if ours > tolerance || ours > (8.0 * burns).max(floor) {
                return Some(format!(
                    "{backbone} of seed {seed}, {what} {index}: {ours:.1e}, Burn {burns:.1e}, allowed \
                     {tolerance:.1e}"
                ));
            }
        }
    }
    None
}

/// The seed of the networks, and those of two others, which both have to be without fault where one of
/// the first is not: where rounding takes a number to the other side of zero, a ReLU lets another
/// gradient through, which is no matter of tolerance. Of 48 residual networks that happened to three with
/// our kernels and to one with Burn's; the others were equally exact.
const SEEDS: [u64; 3] = [3, 4, 5];

#[test]
fn our_kernels_train_as_burns_do() {
    let [first, others @ ..] = SEEDS;
    for backbone in BACKBONES.iter().map(|entry| entry.name) {
        if let Some(found) = fault(backbone, first) {
            let more: Vec<_> = others.iter().filter_map(|seed| fault(backbone, *seed)).collect();
            assert!(more.is_empty(), "{found}, {more:?}");
        }
    }
    let twice = [first; 2].map(|seed| step("resnet18", seed, Arithmetic::Ours));
    assert!(twice[0] == twice[1]);
}
