//! Agreement with PyTorch: imported weights, every backbone, the loss, a few training steps.

use burn::module::Module;
use burn::optim::{AdamConfig, GradientsParams};
use burn::tensor::{Device, Tensor};
use evpose_nn::parameters::{fill, read};
use evpose_nn::weights::load_pytorch;
use evpose_nn::{BACKBONES, HandLoss, HandRegressor, HandRegressorConfig, NnError};

use crate::golden::{closed_form, data, first_id, golden, images, small, targets, values, worst};

const TOLERANCE: f32 = 1e-4;

#[test]
fn both_containers_give_the_outputs_of_pytorch() {
    let device = Device::flex();
    for container in ["small_zip.ckpt", "small_legacy.ckpt"] {
        let network = load_pytorch(&data(container), &small(), &device).unwrap();
        for (size, expected) in golden().checkpoint {
            let (height, width) = size.split_once('x').unwrap();
            let (height, width) = (height.parse().unwrap(), width.parse().unwrap());
            let batch = expected.len() / 12;
            let outputs = values(network.forward(images(batch, height, width, &device)));
            let worst = worst(&outputs, &expected);
            assert!(worst < TOLERANCE, "{container} {size}: {worst}");
        }
    }
}

#[test]
fn a_bare_state_dict_is_read_like_a_checkpoint() {
    let device = Device::flex();
    let config = HandRegressorConfig { width: 1.0 / 64.0, ..small() };
    let network = load_pytorch(&data("tiny_state_dict.pth"), &config, &device).unwrap();
    let outputs = values(network.forward(images(2, 36, 48, &device)));
    assert!(worst(&outputs, &golden().state_dict) < TOLERANCE);
}

/// Relative widths at which PyTorch's values were computed.
const WIDTHS: [(&str, f32); 10] = [
    ("resnet18", 0.25),
    ("resnet34", 0.125),
    ("mobilenet_v2", 1.0),
    ("vgg11_bn", 0.125),
    ("vgg13_bn", 0.125),
    ("vgg16_bn", 0.125),
    ("vgg19_bn", 0.125),
    ("shufflenet_v2", 1.0),
    ("mnasnet", 1.0),
    ("inception_v3", 1.0),
];

/// Height and width of the images for outputs, and of those for gradients.
fn sizes(backbone: &str) -> [[usize; 2]; 2] {
    match backbone {
        // It needs 75 pixels along each side.
        "inception_v3" => [[80, 107], [75, 100]],
        _ => [[45, 60], [73, 100]],
    }
}

/// A network whose weights are closed forms.
fn formula(backbone: &str, width: f32, device: &Device) -> HandRegressor {
    let config = HandRegressorConfig {
        backbone: backbone.to_owned(),
        width,
        ..HandRegressorConfig::default()
    };
    let mut position = 0;
    fill(config.init(0, device).unwrap(), |slot| {
        position += 1;
        closed_form(slot, position - 1)
    })
}

#[test]
fn every_backbone_computes_what_torchvision_computes() {
    let device = Device::flex();
    for (backbone, width) in WIDTHS {
        let network = formula(backbone, width, &device);
        let [[height, width], _] = sizes(backbone);
        let outputs = values(network.forward(images(2, height, width, &device)));
        let worst = worst(&outputs, &golden().formula[backbone]);
        assert!(worst < TOLERANCE, "{backbone}: {worst}");
    }
    // Fields of the average that overlap; at 45x60 a single pixel fills them all.
    let vgg = formula("vgg11_bn", 0.125, &device);
    let outputs = values(vgg.forward(images(2, 73, 100, &device)));
    let worst = worst(&outputs, &golden().pooled);
    assert!(worst < TOLERANCE, "{worst}");
}

/// Whether kernels compute with the vectors of the longest kind.
fn has_avx512() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("avx512f");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

#[test]
fn every_backbone_has_the_gradient_of_torchvision() {
    let device = Device::flex().autodiff();
    assert_eq!(
        WIDTHS.map(|(name, _)| name).to_vec(),
        BACKBONES.iter().map(|e| e.name).collect::<Vec<_>>()
    );
    for (backbone, width) in WIDTHS {
        let expected = &golden().gradient[backbone];
        let network = formula(backbone, width, &device);
        let [_, [height, width]] = sizes(backbone);
        let outputs = network.forward(images(8, height, width, &device));
        let objective = HandLoss::default().forward(outputs, targets(8, &device)).objective;
        let difference = objective.clone().into_scalar::<f32>() - expected.objective;
        // Elsewhere sums have another order, which Inception's ninety normalisations of few pixels amplify: on AVX2
        // to 2.5e-5 and to 9 % of the largest.
        let (difference_below, error_below) =
            if backbone == "inception_v3" && !has_avx512() { (3e-5, 0.12) } else { (1e-5, 0.06) };
        assert!(difference.abs() < difference_below, "{backbone}: {difference}");
        let gradients = GradientsParams::from_grads(objective.backward(), &network);
        let id = first_id(&network);
        let gradient = values(gradients.get::<4>(id).unwrap());
        // The golden values are of double precision. In single precision PyTorch itself is off by up to
        // 3 % of the largest: fifty normalisations of few pixels amplify rounding. The direction is that of
        // the golden gradient.
        let cosine_above = if backbone == "inception_v3" { 0.995 } else { 0.9995 };
        let dot = |a: &[f32], b: &[f32]| -> f64 {
            a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
        };
        let golden = &expected.conv1_weight;
        let cosine =
            dot(&gradient, golden) / (dot(&gradient, &gradient) * dot(golden, golden)).sqrt();
        assert!(cosine > cosine_above, "{backbone}: {cosine}");
        let largest = golden.iter().fold(0.0f32, |a, b| a.max(b.abs()));
        let error = worst(&gradient, golden) / largest;
        assert!(error < error_below, "{backbone}: {error}");
    }
}

#[test]
fn the_loss_and_its_gradient_are_those_of_pytorch() {
    let device = Device::flex().autodiff();
    let expected = golden().loss;
    let target = targets(5, &device);
    let prediction = (target.clone() * 0.5 + 0.01).detach().require_grad();
    let parts = HandLoss::default().forward(prediction.clone(), target);
    let gradients = parts.objective.backward();
    let gradient = values(prediction.grad(&gradients).unwrap());
    let relative = |ours: Tensor<1>, theirs: f32| {
        let ours = ours.into_scalar::<f32>();
        assert!((ours / theirs - 1.0).abs() < 1e-5, "{ours} {theirs}");
    };
    relative(parts.total, expected.total);
    relative(parts.objective, expected.objective);
    relative(parts.articulation, expected.articulation);
    relative(parts.translation_m2, expected.translation_m2);
    relative(parts.depth_m2, expected.depth_m2);
    relative(parts.rotation_rad2, expected.rotation_rad2);
    assert!(worst(&gradient, &expected.gradient) < 1e-5);
}

#[test]
fn four_steps_of_adam_lower_the_loss_as_in_pytorch() {
    let device = Device::flex().autodiff();
    let expected = golden().training;
    let mut network = load_pytorch(&data("small_zip.ckpt"), &small(), &device).unwrap();
    // PyTorch's epsilon; Burn's default is a thousand times larger.
    let mut adam = AdamConfig::new().with_epsilon(1e-8).init();
    let mut objectives = Vec::new();
    for _ in 0..4 {
        let outputs = network.forward(images(8, 36, 48, &device));
        let loss = HandLoss::default().forward(outputs, targets(8, &device)).objective;
        objectives.push(loss.clone().into_scalar::<f32>());
        let gradients = GradientsParams::from_grads(loss.backward(), &network);
        network = adam.step(1e-3, network, gradients);
    }
    // The first steps of Adam follow the sign of each gradient: rounding near zero shows.
    let worst_objective = worst(&objectives, &expected.objective);
    assert!(worst_objective < 1e-3, "{objectives:?} for {:?}", expected.objective);
    let mean = read(&network.valid());
    let mean = mean.iter().find(|(slot, _)| slot.path == "backbone.stem.norm.running_mean");
    assert!(worst(&mean.unwrap().1, &expected.bn1_running_mean) < 1e-3);
}

#[test]
fn weights_of_another_network_are_named() {
    let wide = HandRegressorConfig { width: 0.125, ..small() };
    let error = load_pytorch(&data("small_zip.ckpt"), &wide, &Device::flex()).unwrap_err();
    let NnError::Mismatch { mismatch, .. } = &error else { panic!("{error}") };
    let fc = ("rn.fc.weight".to_owned(), vec![12, 64], vec![12, 32]);
    assert!(mismatch.reshaped.contains(&fc), "{error}");

    let deep = HandRegressorConfig { backbone: "resnet34".to_owned(), ..small() };
    let error = load_pytorch(&data("small_zip.ckpt"), &deep, &Device::flex()).unwrap_err();
    let NnError::Mismatch { mismatch, .. } = &error else { panic!("{error}") };
    assert!(mismatch.missing.contains(&"rn.layer3.5.bn2.running_var".to_owned()), "{error}");
    assert!(mismatch.unexpected.is_empty(), "{error}");

    let other = HandRegressorConfig { backbone: "mobilenet_v2".to_owned(), ..small() };
    let error = load_pytorch(&data("small_zip.ckpt"), &other, &Device::flex()).unwrap_err();
    let NnError::Mismatch { mismatch, .. } = &error else { panic!("{error}") };
    assert!(mismatch.unexpected.contains(&"rn.conv1.weight".to_owned()), "{error}");
}

#[test]
fn damaged_and_foreign_files_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("weights.ckpt");
    let load = || load_pytorch(&path, &small(), &Device::flex()).map(|_| ()).unwrap_err();
    assert!(matches!(load(), NnError::Io { .. }));
    for foreign in [&b""[..], b"GIF89a", b"\x80\x02}q\x00.", b"PK\x03\x04", &[0x80; 4096]] {
        std::fs::write(&path, foreign).unwrap();
        assert!(matches!(load(), NnError::Unreadable { .. } | NnError::Mismatch { .. }));
    }
    for container in ["small_zip.ckpt", "small_legacy.ckpt"] {
        let whole = std::fs::read(data(container)).unwrap();
        for length in (0..whole.len()).step_by(whole.len() / 40).chain([whole.len() - 1]) {
            std::fs::write(&path, &whole[..length]).unwrap();
            let error = load();
            assert!(matches!(error, NnError::Unreadable { .. }), "{container} {length}: {error}");
        }
        // Damage inside never panics. A zip archive has checksums: nothing wrong is ever loaded.
        let intact = read(&load_pytorch(&data(container), &small(), &Device::flex()).unwrap());
        for offset in (0..whole.len()).step_by(whole.len() / 60) {
            let mut damaged = whole.clone();
            let end = (offset + 16).min(damaged.len());
            damaged[offset..end].fill(0xff);
            std::fs::write(&path, &damaged).unwrap();
            if let Ok(loaded) = load_pytorch(&path, &small(), &Device::flex()) {
                let zip = container == "small_zip.ckpt";
                assert!(!zip || read(&loaded) == intact, "{container} {offset}");
            }
        }
    }
}
