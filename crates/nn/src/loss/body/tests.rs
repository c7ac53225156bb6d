//! The loss and its gradients as another program gives them, and what it must not depend on.

use burn::tensor::{Device, TensorData};
use proptest::prelude::*;

use super::*;

const BATCH: usize = 3;
const JOINTS: usize = 13;
const SIDE: usize = 8;
const CELLS: usize = SIDE * SIDE;

/// The fraction of `43758.5453 sin(12.9898 i + 78.233 stream)`.
fn hashed(count: usize, stream: usize) -> Vec<f64> {
    let value = |i: usize| (12.9898 * i as f64 + 78.233 * stream as f64).sin() * 43758.5453;
    (0..count).map(|i| value(i) - value(i).floor()).collect()
}

fn tensor<const D: usize>(
    shape: [usize; D],
    stream: usize,
    device: &Device,
    of: impl Fn(f64) -> f64,
) -> Tensor<D> {
    let values = hashed(shape.iter().product(), stream);
    let values: Vec<f32> = values.into_iter().map(|u| of(u) as f32).collect();
    Tensor::from_data(TensorData::new(values, shape), device)
}

fn cells(count: usize, stream: usize) -> Vec<i32> {
    hashed(count, stream).into_iter().map(|u| (u * CELLS as f64) as i32).collect()
}

fn maps(device: &Device) -> BodyMaps<Tensor<4>> {
    let pairs = [BATCH, 2 * JOINTS, SIDE, SIDE];
    BodyMaps {
        heatmaps: tensor([BATCH, JOINTS, SIDE, SIDE], 1, device, |u| u),
        centers: tensor([BATCH, 1, SIDE, SIDE], 2, device, |u| u),
        regs: tensor(pairs, 3, device, |u| 20.0 * (u - 0.5)),
        offsets: tensor(pairs, 4, device, |u| u),
    }
}

/// Joint 4 is known in no sample.
fn targets(device: &Device) -> BodyTargets {
    let joint_cells = TensorData::new(cells(BATCH * JOINTS, 8), [BATCH, JOINTS]);
    let known = tensor([BATCH, JOINTS], 11, device, |u| f64::from(u > 0.3));
    // Joint 4 is known in no sample: the losses have to do without it throughout.
    let has_four: [[f32; JOINTS]; BATCH] =
        [std::array::from_fn(|joint| f32::from(u8::from(joint != 4))); BATCH];
    let has_four: Tensor<2> = Tensor::from_data(TensorData::from(has_four), device);
    BodyTargets {
        heatmaps: tensor([BATCH, JOINTS, SIDE, SIDE], 5, device, |u| u.powi(4)),
        centers: tensor([BATCH, 1, SIDE, SIDE], 6, device, |u| u.powi(4)),
        center_cells: Tensor::from_data(TensorData::new(cells(BATCH, 7), [BATCH]), device),
        joint_cells: Tensor::from_data(joint_cells, device),
        regs: tensor([BATCH, JOINTS, 2], 9, device, |u| 20.0 * (u - 0.5)),
        offsets: tensor([BATCH, JOINTS, 2], 10, device, |u| u),
        known: known * has_four,
    }
}

fn loss(parity: bool) -> BodyLoss {
    BodyLoss::new(BodyLossConfig { parity, ..BodyLossConfig::default() }, JOINTS)
}

fn values(parts: BodyLossParts) -> [f32; 6] {
    let BodyLossParts { total, heatmap, bone, center, regs, offsets } = parts;
    [total, heatmap, bone, center, regs, offsets].map(|part| part.into_scalar::<f32>())
}

fn close(ours: f32, theirs: f32) {
    assert!((ours - theirs).abs() <= 1e-5 * theirs.abs(), "{ours} for {theirs}");
}

// Made with PyTorch 2.15 in f64 from the same closed forms, written as the published program has
// them (loops over joints and bones, indices into dense maps); by default with our limbs and a norm
// for each sample. Gradients are those of the total, multiplied by hashed values (streams 20 to
// 23) and summed over each of the four maps.
const PARITY: [f32; 6] = [153.9307, 32.6319, 2.601128, 27.71302, 13.64787, 0.6196107];
const PARITY_GRADIENTS: [f32; 4] = [14.04356, 21.37881, -0.09409189, -0.3608149];
const DEFAULT: [f32; 6] = [113.0549, 32.6319, 0.5573365, 27.71302, 13.64787, 0.6196107];
const DEFAULT_GRADIENTS: [f32; 4] = [13.70231, 21.37881, -0.09409189, -0.3608149];

#[test]
fn the_loss_and_its_gradients_are_those_of_another_program() {
    let device = Device::flex().autodiff();
    for (parity, expected, gradients) in
        [(true, PARITY, PARITY_GRADIENTS), (false, DEFAULT, DEFAULT_GRADIENTS)]
    {
        let inputs = maps(&device).into_array().map(Tensor::require_grad);
        let parts = loss(parity).forward(BodyMaps::from_array(inputs.clone()), targets(&device));
        let tape = parts.total.clone().backward();
        for (ours, theirs) in values(parts).into_iter().zip(expected) {
            close(ours, theirs);
        }
        for (index, (input, theirs)) in inputs.into_iter().zip(gradients).enumerate() {
            let gradient = input.grad(&tape).unwrap();
            let weights = tensor(gradient.dims(), 20 + index, &gradient.device(), |u| u);
            close((gradient * weights).sum().into_scalar(), theirs);
        }
    }
}

#[test]
fn a_perfect_prediction_has_neither_loss_nor_gradient() {
    let device = Device::flex().autodiff();
    let targets = targets(&device);
    // Constant maps of the targets: right at whichever cell they are read.
    let plane = |target: Tensor<3>| {
        let target = target.reshape([BATCH, 2 * JOINTS, 1, 1]);
        target.repeat_dim(2, SIDE).repeat_dim(3, SIDE)
    };
    let maps = BodyMaps {
        heatmaps: targets.heatmaps.clone(),
        centers: targets.centers.clone(),
        regs: plane(targets.regs.clone()),
        offsets: plane(targets.offsets.clone()),
    };
    for parity in [false, true] {
        let inputs = maps.clone().into_array().map(|map| map.detach().require_grad());
        let parts = loss(parity).forward(BodyMaps::from_array(inputs.clone()), targets.clone());
        let tape = parts.total.clone().backward();
        // The bones' share is the root of what keeps its gradient finite.
        let (total, bone) = (parts.total.into_scalar::<f32>(), parts.bone.into_scalar::<f32>());
        assert!(bone <= 1e-6 && (total - 20.0 * bone).abs() < 1e-9, "{total}");
        for input in inputs {
            assert_eq!(input.grad(&tape).unwrap().abs().sum().into_scalar::<f32>(), 0.0);
        }
    }
}

#[test]
fn a_batch_twice_over_costs_the_same_but_for_published_bones() {
    let device = Device::flex();
    let (maps, targets) = (maps(&device), targets(&device));
    let twice = |tensor: Tensor<4>| tensor.repeat_dim(0, 2);
    let double = BodyTargets {
        heatmaps: twice(targets.heatmaps.clone()),
        centers: twice(targets.centers.clone()),
        center_cells: targets.center_cells.clone().repeat_dim(0, 2),
        joint_cells: targets.joint_cells.clone().repeat_dim(0, 2),
        regs: targets.regs.clone().repeat_dim(0, 2),
        offsets: targets.offsets.clone().repeat_dim(0, 2),
        known: targets.known.clone().repeat_dim(0, 2),
    };
    let double_maps = BodyMaps::from_array(maps.clone().into_array().map(twice));
    for (parity, bones) in [(false, 1.0), (true, 0.5f32.sqrt())] {
        let once = values(loss(parity).forward(maps.clone(), targets.clone()));
        let both = values(loss(parity).forward(double_maps.clone(), double.clone()));
        for part in [1, 3, 4, 5] {
            // Of three samples, 1e-4 keeps a little off the mean.
            assert!((once[part] - both[part]).abs() < 1e-4 * once[part], "part {part}");
        }
        close(both[2], bones * once[2]);
    }
}

#[test]
fn half_a_body_has_the_limbs_of_its_joints() {
    let bones = |joints, parity| {
        BodyLoss::new(BodyLossConfig { parity, ..BodyLossConfig::default() }, joints).bones
    };
    assert_eq!(bones(7, false), [[2, 4], [4, 6], [1, 3], [3, 5], [2, 1]]);
    assert_eq!(bones(13, false).len(), LIMBS.len());
    assert_eq!(bones(7, true), PARITY_BONES);
}

#[test]
fn a_joint_alone_has_no_limbs_and_costs_nothing_for_them() {
    let device = Device::flex();
    let error = Tensor::ones([2, 1, 3, 3], &device);
    for parity in [false, true] {
        let config = BodyLossConfig { parity, ..BodyLossConfig::default() };
        assert_eq!(BodyLoss::new(config, 1).bone(&error).into_scalar::<f32>(), 0.0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    #[test]
    fn what_is_not_known_or_not_read_does_not_count(
        sample in 0..BATCH,
        joint in 0..JOINTS,
        axis in 0..2usize,
        cell in 0..CELLS,
        by in 1f32..9.0,
    ) {
        let device = Device::flex();
        let (maps, targets) = (maps(&device), targets(&device));
        let before = values(loss(false).forward(maps.clone(), targets.clone()));
        let mut changed = maps.regs.clone().into_data().iter::<f32>().collect::<Vec<_>>();
        changed[((sample * JOINTS + joint) * 2 + axis) * CELLS + cell] += by;
        let regs = Tensor::from_data(TensorData::new(changed, maps.regs.dims()), &device);
        let center_cells = cells(BATCH, 7);
        let known = targets.known.clone().into_data().iter::<f32>().collect::<Vec<_>>();
        let is_known = known[sample * JOINTS + joint] == 1.0;
        let is_read = is_known && center_cells[sample] as usize == cell;
        let after = values(loss(false).forward(BodyMaps { regs, ..maps }, targets));
        prop_assert_eq!(before == after, !is_read);
    }
}
