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
fn step(backbone: &str, arithmetic: Arithmetic) -> [Vec<Vec<f64>>; 3] {
    set_training_kernels(matches!(arithmetic, Arithmetic::Ours));
    let device = Device::flex().autodiff();
    let config = HandRegressorConfig { backbone: backbone.to_owned(), width: 0.125 };
    let mut network = config.init(3, &device).unwrap();
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

#[test]
fn our_kernels_train_as_burns_do() {
    for backbone in BACKBONES.iter().map(|entry| entry.name) {
        let [ours, burns, truth] =
            [Arithmetic::Ours, Arithmetic::Burns, Arithmetic::Double].map(|by| step(backbone, by));
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
                let place = format!("{backbone} {what} {index}: {ours:.1e}, Burn {burns:.1e}");
                assert!(ours <= tolerance, "{place}, allowed {tolerance:.1e}");
                assert!(ours <= (8.0 * burns).max(floor), "{place}");
            }
        }
    }
    let twice = [step("resnet18", Arithmetic::Ours), step("resnet18", Arithmetic::Ours)];
    assert!(twice[0] == twice[1]);
}
