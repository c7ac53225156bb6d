//! Training with our own kernels against training with Burn's.
//!
//! One test: the switch between them holds for the whole process.

#![allow(clippy::unwrap_used, reason = "tests")]

mod golden;

use burn::module::{Module, ModuleVisitor, Param};
use burn::tensor::{Device, Gradients, Tensor};
use evpose_nn::parameters::read;
use evpose_nn::{BACKBONES, HandLoss, HandRegressorConfig, set_training_kernels};
use golden::{images, targets};

struct Flattened<'a> {
    gradients: &'a Gradients,
    found: Vec<Vec<f32>>,
}

impl ModuleVisitor for Flattened<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        if let Some(gradient) = param.val().grad(self.gradients) {
            self.found.push(gradient.into_data().iter::<f32>().collect());
        }
    }
}

/// Output, gradients of all parameters, and the running statistics afterwards.
fn step(backbone: &str, ours: bool) -> [Vec<Vec<f32>>; 3] {
    set_training_kernels(ours);
    let device = Device::flex().autodiff();
    let config = HandRegressorConfig { backbone: backbone.to_owned(), width: 0.125 };
    let network = config.init(3, &device).unwrap();
    let outputs = network.forward(images(6, 45, 60, &device));
    let values = outputs.clone().into_data().iter::<f32>().collect();
    let loss = HandLoss::default().forward(outputs, targets(6, &device)).objective;
    let gradients = loss.backward();
    let mut flattened = Flattened { gradients: &gradients, found: Vec::new() };
    network.visit(&mut flattened);
    let state = read(&network).into_iter().map(|(_, values)| values).collect();
    [vec![values], flattened.found, state]
}

fn size(values: &[f32]) -> f32 {
    values.iter().fold(0.0, |size, value| size.max(value.abs()))
}

#[test]
fn our_kernels_train_as_burns_do() {
    for backbone in BACKBONES.iter().map(|entry| entry.name) {
        let (ours, burns) = (step(backbone, true), step(backbone, false));
        for (what, (ours, burns)) in
            ["output", "gradient", "state"].iter().zip(ours.iter().zip(&burns))
        {
            assert!(!ours.is_empty() && ours.len() == burns.len());
            let largest = size(&burns.concat());
            for (index, (ours, burns)) in ours.iter().zip(burns).enumerate() {
                assert_eq!(ours.len(), burns.len());
                let differences: Vec<f32> = ours.iter().zip(burns).map(|(a, b)| a - b).collect();
                // In front of a normalisation some gradients are zero but for rounding: sums of
                // thousands of terms, each of which is rounded at 1.2e-7 of the largest.
                let tolerance = (1e-4 * size(burns)).max(4.0 * f32::EPSILON * largest);
                let error = size(&differences);
                assert!(error <= tolerance, "{backbone} {what} {index}: {error}");
            }
        }
    }
    let twice = [step("resnet18", true), step("resnet18", true)];
    assert!(twice[0] == twice[1]);
}
