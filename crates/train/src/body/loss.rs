//! The body network's loss on a batch.

use burn::tensor::Tensor;
use evpose_nn::{BodyLoss, MoveEnet};
use evpose_pose::body::{BodyDecoder, BodyLabel, BodyMaps, DEFAULT_THRESHOLD};

use super::accuracy::{BodyAccuracy, BodyAccuracyConfig};
use super::loader::BodyItem;
use crate::metric::{BatchValues, LOSS, LoggedValue};
use crate::training::TrainingLoss;

/// The values that trainings of bodies log for each batch: the loss and its parts, and the published
/// accuracy, the share of joints at most a fifth of the torso from where they should be.
pub const BODY_VALUES: [LoggedValue; 7] = [
    LoggedValue::error(LOSS, ""),
    LoggedValue::error("heatmap", ""),
    LoggedValue::error("bone", ""),
    LoggedValue::error("center", ""),
    LoggedValue::error("regs", ""),
    LoggedValue::error("offsets", ""),
    LoggedValue { name: "accuracy", unit: "", higher_is_better: true },
];

impl TrainingLoss<MoveEnet> for BodyLoss {
    type Batch = BodyItem;

    fn inputs(batch: &mut BodyItem) -> &mut Tensor<4> {
        &mut batch.images
    }

    fn measure(&self, network: &MoveEnet, item: BodyItem) -> (Tensor<1>, BatchValues) {
        let maps = network.forward(item.images);
        let accuracy = accuracy(&maps, &item.labels);
        let parts = self.forward(maps, item.targets);
        let read = |tensor: &Tensor<1>| f64::from(tensor.clone().into_scalar::<f32>());
        let values = vec![
            read(&parts.total),
            read(&parts.heatmap),
            read(&parts.bone),
            read(&parts.center),
            read(&parts.regs),
            read(&parts.offsets),
            accuracy,
        ];
        (parts.total, BatchValues { samples: item.labels.len(), values })
    }
}

/// The share of correctly detected joints; not a number if no joint has a label and a length to compare
/// with.
fn accuracy(maps: &BodyMaps<Tensor<4>>, labels: &[BodyLabel]) -> f64 {
    let [batch, joints, rows, columns] = maps.heatmaps.dims();
    let decoder = BodyDecoder::new([rows, columns], DEFAULT_THRESHOLD);
    let values = |map: &Tensor<4>| -> Vec<f32> { map.clone().into_data().iter().collect() };
    let all = [&maps.heatmaps, &maps.centers, &maps.regs, &maps.offsets].map(values);
    let mut counts = BodyAccuracy::new(joints);
    for (sample, label) in labels.iter().enumerate() {
        let of = |map: &'_ [f32]| {
            let size = map.len() / batch;
            sample * size..(sample + 1) * size
        };
        let maps =
            BodyMaps::from_array([&all[0], &all[1], &all[2], &all[3]].map(|map| &map[of(map)]));
        counts.push(BodyAccuracyConfig::default(), &decoder.decode(&maps), label);
    }
    counts.mean().unwrap_or(f64::NAN)
}
