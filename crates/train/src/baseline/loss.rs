//! A baseline's loss on a batch.

use burn::tensor::Tensor;
use evpose_nn::{BaselineNetwork, heatmap_loss, marginal_loss};
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use glam::Vec2;

use super::batches::{BaselineItem, BaselineTargets};
use super::{dhp19, lift_mono};
use crate::metric::{BatchValues, LOSS, LoggedValue};
use crate::training::TrainingLoss;

/// The values logged per step: the loss, and the mean distance of joints in view from where they should
/// be, in pixels of the input.
pub(super) const BASELINE_VALUES: [LoggedValue; 2] =
    [LoggedValue::error(LOSS, ""), LoggedValue::error("error_px", "px")];

/// The loss of either network.
#[derive(Debug, Clone)]
pub(super) struct BaselineLoss {
    /// Deviation of the targets of `lift-mono`, in cells.
    pub(super) sigma_cells: f32,
}

impl TrainingLoss<BaselineNetwork> for BaselineLoss {
    type Batch = BaselineItem;

    fn inputs(batch: &mut BaselineItem) -> &mut Tensor<4> {
        &mut batch.images
    }

    fn measure(&self, network: &BaselineNetwork, item: BaselineItem) -> (Tensor<1>, BatchValues) {
        // The size of the images, since joints are compared in pixels.
        let [samples, _, height, width] = item.images.dims();
        let size_px = Vec2::new(width as f32, height as f32);
        let (loss, joints_px) = match (network, &item.targets) {
            (BaselineNetwork::Dhp19Cnn(network), BaselineTargets::Heatmaps(targets)) => {
                let maps = network.forward(item.images);
                let joints_px = dhp19::peaks_px(&maps);
                (heatmap_loss(maps, targets), joints_px)
            }
            (BaselineNetwork::LiftMono(network), BaselineTargets::Marginals(targets)) => {
                let stages = network.forward(item.images);
                // The last stage is the answer; the others only help it to learn.
                let positions = stages.last().map(|maps| maps.positions());
                let joints_px =
                    positions.map_or_else(Vec::new, |at| lift_mono::positions_px(at, size_px));
                (marginal_loss(&stages, targets, self.sigma_cells).total, joints_px)
            }
            _ => unreachable!("batches are those of the network"),
        };
        let error_px = mean_error_px(&joints_px, &item.joints_px);
        let values = vec![f64::from(loss.clone().into_scalar::<f32>()), error_px];
        (loss, BatchValues { samples, values })
    }
}

/// The mean distance over joints in view; 0 if none is.
fn mean_error_px(joints_px: &[Vec2], labels_px: &[BodyPoints]) -> f64 {
    let (mut sum, mut count) = (0.0, 0u64);
    for (joints_px, labels_px) in joints_px.chunks(BODY_JOINTS).zip(labels_px) {
        for (joint, label) in joints_px.iter().zip(labels_px) {
            let Some(label) = label else { continue };
            sum += f64::from(joint.distance(*label));
            count += 1;
        }
    }
    sum / count.max(1) as f64
}

#[cfg(test)]
mod tests {
    use burn::tensor::{Device, TensorData};

    use super::*;

    #[test]
    fn joints_are_read_in_pixels_and_those_out_of_view_do_not_count() {
        let mut values = vec![0.0f32; 2 * 3 * 4];
        (values[6], values[12 + 11]) = (1.0, 2.0);
        let maps = Tensor::<4>::from_data(TensorData::new(values, [1, 2, 3, 4]), &Device::flex());
        assert_eq!(dhp19::peaks_px(&maps), [Vec2::new(2.5, 1.5), Vec2::new(3.5, 2.5)]);
        let at = TensorData::new(vec![0.0f32, -1.0, 0.3], [1, 1, 3]);
        let at = Tensor::<3>::from_data(at, &Device::flex());
        assert_eq!(lift_mono::positions_px(at, Vec2::new(8.0, 4.0)), [Vec2::new(4.0, 0.0)]);
        let mut label = BodyPoints::default();
        label[1] = Some(Vec2::new(3.0, 4.0));
        let error = mean_error_px(&[Vec2::ZERO; BODY_JOINTS], &[label]);
        assert_eq!(error, 5.0);
    }
}
