//! Images with targets as batches, each time a little different.

use std::ops::Range;
use std::sync::Arc;

use burn::data::dataset::DatasetError;
use burn::tensor::{Device, Tensor, TensorData};
use evpose_core::seed_for;
use evpose_nn::BodyTargets;
use evpose_pose::body::BodyLabel;
use evpose_task::body::{BodyAugmentation, BodyConfig, Interpolation};
use rayon::prelude::*;

use super::augmentation::{self, BodyView};
use super::batch::BodyBatch;
use super::frames::BodyFrames;
use super::targets::BodyGrid;
use crate::batch_loader::BatchSource;
use crate::order::SampleOrder;
use crate::passes::Passes;

/// Channels of the network's input, all the same.
const CHANNELS: usize = 3;
/// Pixels of the input for each cell of the maps.
const CELL_PX: usize = 4;

/// Images with targets and labels.
#[derive(Debug, Clone)]
pub struct BodyItem {
    /// `[batch, 3, side, side]`, 0 to 255.
    pub(super) images: Tensor<4>,
    pub(super) targets: BodyTargets,
    pub(super) labels: Vec<BodyLabel>,
}

/// Images that become batches: augmented in training, as they are in validation.
#[derive(Clone)]
pub(super) struct BodyBatches {
    data: Arc<BodyFrames>,
    side_px: usize,
    seed: u64,
    order: SampleOrder,
    grid: Arc<BodyGrid>,
    augmentation: Arc<BodyAugmentation>,
    interpolation: Interpolation,
}

/// A batch in the memory of the host, not yet on the device.
pub(super) struct HostBatch {
    images: Vec<f32>,
    batch: BodyBatch,
    labels: Vec<BodyLabel>,
}

impl BodyBatches {
    pub(super) fn new(data: Arc<BodyFrames>, config: &BodyConfig) -> Self {
        let side_px = config.image.side_px;
        Self {
            order: SampleOrder::new(data.len() as u64, seed_for(config.seed, "body order", 0)),
            data,
            side_px,
            seed: seed_for(config.seed, "body views", 0),
            grid: Arc::new(BodyGrid::new(side_px / CELL_PX, config.targets.parity)),
            augmentation: Arc::new(config.augmentation.clone()),
            interpolation: config.image.interpolation,
        }
    }

    /// The image of the sample at a position, and its view.
    fn view(&self, passes: &Passes, position: u64) -> (usize, BodyView) {
        let index = passes.sample(&self.order, self.data.len(), position);
        let label = &self.data.frames[index].label;
        let view = match passes {
            Passes::Training { .. } => {
                // By position, not by index: an image has another view in every pass.
                augmentation::draw(&self.augmentation, self.seed, position, label)
            }
            Passes::Validation { .. } => BodyView::plain(label, self.interpolation),
        };
        (index, view)
    }
}

impl BatchSource for BodyBatches {
    type Host = HostBatch;
    type Item = BodyItem;

    fn host_batch(
        &self,
        passes: &Passes,
        positions: Range<u64>,
    ) -> Result<HostBatch, DatasetError> {
        let count = (positions.end - positions.start) as usize;
        let pixels = self.side_px * self.side_px;
        let mut images = vec![0.0; count * CHANNELS * pixels];
        let joints = self.data.frames[0].label.keypoints.len();
        let mut batch = BodyBatch::new(count, joints, self.side_px / CELL_PX);
        let labels = images
            .par_chunks_mut(CHANNELS * pixels)
            .zip(batch.samples_mut())
            .enumerate()
            .map(|(k, (image, mut targets))| {
                // A view depends on its position alone, so that threads make them in any order.
                let (index, view) = self.view(passes, positions.start + k as u64);
                let (first, others) = image.split_at_mut(pixels);
                view.render(&self.data.frames[index].image, self.side_px, first);
                // The network takes colours; grey is the same in each.
                others.chunks_mut(pixels).for_each(|channel| channel.copy_from_slice(first));
                self.grid.write(view.label(), &mut targets);
                view.label().clone()
            })
            .collect();
        Ok(HostBatch { images, batch, labels })
    }

    fn item(&self, host: HostBatch, device: &Device) -> BodyItem {
        let shape = [host.labels.len(), CHANNELS, self.side_px, self.side_px];
        BodyItem {
            images: Tensor::from_data(TensorData::new(host.images, shape), device),
            targets: host.batch.into_tensors(device),
            labels: host.labels,
        }
    }
}
