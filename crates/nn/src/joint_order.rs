//! Joints in another order: weights of networks whose outputs were counted differently.

use burn::module::Module;

use crate::parameters::{Slot, fill, read};

/// The joints of DHP19 in the order of our networks: its own are head, shoulders, elbows, hips,
/// hands, knees and feet, the right one first.
pub(crate) const NETWORK_FROM_DHP19: [usize; 13] = [0, 2, 1, 4, 3, 8, 7, 6, 5, 10, 9, 12, 11];

/// The axes of a tensor that count joints.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct JointAxes {
    /// The first: outputs of a layer.
    pub(crate) first: bool,
    /// The second: its inputs, one or several for each joint.
    pub(crate) second: bool,
}

/// A network whose joint `k` is the given one's `order[k]`; `axes` says which tensors count joints.
pub(crate) fn reordered<M: Module>(
    network: M,
    order: &[usize],
    axes: impl Fn(&Slot) -> JointAxes,
) -> M {
    let mut values = read(&network).into_iter();
    fill(network, |slot| {
        // Reading and filling visit the tensors in the same order.
        let (_, values) = values.next().unwrap_or_else(|| unreachable!("every slot is read"));
        let JointAxes { first, second } = axes(slot);
        let [outer, inner] = match *slot.shape.as_slice() {
            [outer, inner, ..] => [outer, inner],
            [outer] => [outer, 1],
            [] => return values,
        };
        let area = slot.shape.iter().skip(2).product::<usize>();
        let from = |index: usize, is_joint: bool| match is_joint {
            // Axes may hold several values for each joint, all joints of the first one before the
            // next.
            true => index / order.len() * order.len() + order[index % order.len()],
            false => index,
        };
        let mut moved = Vec::with_capacity(values.len());
        for row in (0..outer).map(|row| from(row, first)) {
            for column in (0..inner).map(|column| from(column, second)) {
                let start = (row * inner + column) * area;
                moved.extend_from_slice(&values[start..start + area]);
            }
        }
        moved
    })
}

#[cfg(test)]
mod tests {
    use burn::tensor::{Device, Tensor, TensorData};

    use crate::{Dhp19CnnConfig, LiftMonoConfig};

    const ORDER: [usize; 3] = [2, 0, 1];

    fn images() -> Tensor<4> {
        let values: Vec<f32> = (0..48 * 64).map(|k| (k * k % 251) as f32).collect();
        Tensor::from_data(TensorData::new(values, [1, 1, 48, 64]), &Device::flex())
    }

    fn values(maps: Tensor<4>) -> Vec<f32> {
        maps.into_data().iter().collect()
    }

    /// The maps of joints in the order of [`ORDER`].
    fn in_order(maps: &Tensor<4>) -> Vec<f32> {
        ORDER.iter().flat_map(|&joint| values(maps.clone().narrow(1, joint, 1))).collect()
    }

    #[test]
    fn reordered_networks_have_the_same_maps_in_another_order() {
        let device = Device::flex();
        let cnn = Dhp19CnnConfig { joints: 3, width: 0.125 }.init(3, &device).unwrap();
        let want = in_order(&cnn.forward(images()));
        assert!(want.iter().any(|value| *value > 0.0));
        assert_eq!(values(cnn.with_joint_order(&ORDER).forward(images())), want);

        let config = LiftMonoConfig { joints: 3, width: 0.0625, stages: 3 };
        let lift = config.init(3, &device).unwrap();
        let want = lift.forward(images());
        let ours = lift.with_joint_order(&ORDER).forward(images());
        let largest =
            |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        let (mut same, mut other) = (0.0f32, 0.0f32);
        for (ours, want) in ours.into_iter().zip(want) {
            for (ours, want) in ours.into_array().into_iter().zip(want.into_array()) {
                let (ours, want) = (values(ours), in_order(&want));
                // Sums over joints are in another order, too.
                same = same.max(largest(&ours, &want));
                other = other.max(largest(&want[..48], &want[48..]));
            }
        }
        assert!(same < 1e-4 && other > 0.1, "{same} {other}");
    }
}
