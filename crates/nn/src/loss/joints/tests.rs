//! Closed forms of the loss, and a network that learns a few joints by heart.

use burn::optim::{AdamConfig, GradientsParams};
use burn::tensor::{Device, TensorData};

use super::*;
use crate::JointNetConfig;

const ROWS: usize = 6;
const COLUMNS: usize = 8;

/// Maps of one image and one joint: logits, depths of the cells, logit of the presence.
fn maps(logits: &[f32], depths: &[f32], presence: f32) -> JointMaps {
    let device = Device::flex();
    let map = |values: &[f32]| {
        Tensor::from_data(TensorData::new(values.to_vec(), [1, 1, ROWS, COLUMNS]), &device)
    };
    let presence = Tensor::from_data(TensorData::new(vec![presence], [1, 1]), &device);
    JointMaps { heatmaps: map(logits), depths: map(depths), presence }
}

fn targets([x, y]: [f32; 2], depth: f32, inside: f32, presence: f32) -> JointTargets {
    let device = Device::flex();
    let single = |value: f32| Tensor::<2>::full([1, 1], value, &device);
    JointTargets {
        positions: Tensor::from_data(TensorData::new(vec![x, y], [1, 1, 2]), &device),
        depths: single(depth),
        inside: single(inside),
        presence: single(presence),
        is_certain: single(1.0),
    }
}

/// Depth, divergence and presence.
fn parts(maps: JointMaps, targets: &JointTargets) -> [f32; 3] {
    let parts = JointLoss::default().forward(maps, targets);
    [parts.depth, parts.divergence, parts.presence].map(|part| part.into_scalar())
}

/// The logits of a Gaussian of one cell about a position.
fn gaussian([x, y]: [f32; 2]) -> Vec<f32> {
    let squares = |cell: usize| {
        let (column, row) = ((cell % COLUMNS) as f32, (cell / COLUMNS) as f32);
        (column - x).powi(2) + (row - y).powi(2)
    };
    (0..ROWS * COLUMNS).map(|cell| -0.5 * squares(cell)).collect()
}

#[test]
fn a_heatmap_that_is_its_target_costs_nothing_and_depths_are_read_where_the_joint_is() {
    let depths: Vec<f32> = (0..ROWS * COLUMNS).map(|cell| (cell % COLUMNS) as f32).collect();
    // In the middle, where no border cuts the Gaussian.
    let middle = [3.5, 2.5];
    let met = parts(maps(&gaussian(middle), &depths, 20.0), &targets(middle, 3.5, 1.0, 1.0));
    assert!(met.iter().all(|part| part.abs() < 1e-4), "{met:?}");
    let beside = parts(maps(&gaussian(middle), &depths, 0.0), &targets([4.0, 3.5], 3.5, 1.0, 1.0));
    // Not where the heatmap is.
    assert!((beside[0] - 0.5).abs() < 1e-2, "{beside:?}");
    // Of Gaussians, half the squared distance.
    assert!((beside[1] - 0.625).abs() < 0.1, "{beside:?}");
    assert!((beside[2] - 2f32.ln()).abs() < 1e-6, "{beside:?}");
}

#[test]
fn joints_outside_are_not_measured_and_want_a_flat_heatmap() {
    let zeros = vec![0.0; ROWS * COLUMNS];
    let outside = targets([40.0, -9.0], 5.0, 0.0, 0.0);
    let flat = parts(maps(&zeros, &zeros, -20.0), &outside);
    assert!(flat.iter().all(|part| part.abs() < 1e-5), "{flat:?}");
    let mut peaked = zeros.clone();
    peaked[9] = 40.0;
    let sure = parts(maps(&peaked, &zeros, 3.0), &outside);
    assert_eq!(sure[0], 0.0);
    assert!(sure[1] > 10.0, "{sure:?}");
    assert!((sure[2] - (1.0 + 3f32.exp()).ln()).abs() < 1e-5, "{sure:?}");
}

/// Two images of one active pixel each: the joints lie about it, and each has its own depth.
#[test]
fn a_network_learns_a_few_joints_by_heart() {
    let device = Device::flex().autodiff();
    let (side, joints) = (32, 21);
    let pixels = [[10usize, 20], [22, 8]];
    let mut values = vec![0.0; 2 * 2 * side * side];
    let (mut positions, mut depths) = (Vec::new(), Vec::new());
    for (image, [x, y]) in pixels.into_iter().enumerate() {
        for row in y - 3..y + 3 {
            let start = (2 * image * side + row) * side;
            values[start + x - 3..start + x + 3].fill(1.0);
        }
        for joint in 0..joints {
            let around = (joint as f32 * 0.3).sin();
            positions.extend([x as f32 / 4.0 - 0.5 + around, y as f32 / 4.0 - 0.5 - around]);
            depths.push(joint as f32 / 20.0 * if image == 0 { 1.0 } else { -1.0 });
        }
    }
    let tensor = |values: Vec<f32>, shape: [usize; 2]| {
        Tensor::<2>::from_data(TensorData::new(values, shape), &device)
    };
    let images = TensorData::new(values, [2, 2, side, side]);
    let images = Tensor::<4>::from_data(images, &device);
    let targets = JointTargets {
        positions: Tensor::from_data(TensorData::new(positions, [2, joints, 2]), &device),
        depths: tensor(depths, [2, joints]),
        inside: Tensor::ones([2, joints], &device),
        presence: tensor(vec![1.0, 1.0], [2, 1]),
        is_certain: tensor(vec![1.0, 1.0], [2, 1]),
    };
    let mut network = JointNetConfig { width: 0.25 }.init(1, &device).unwrap();
    let mut adam = AdamConfig::new().init();
    let mut last = [f32::INFINITY; 2];
    for _ in 0..80 {
        let parts = JointLoss::default().forward(network.forward(images.clone()), &targets);
        last = [parts.divergence.into_scalar(), parts.depth.into_scalar()];
        let gradients = GradientsParams::from_grads(parts.total.backward(), &network);
        network = adam.step(5e-3, network, gradients);
    }
    assert!(last[0] < 0.1 && last[1] < 0.1, "nats and palms: {last:?}");
}
