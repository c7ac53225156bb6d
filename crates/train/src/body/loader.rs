//! Batches of images in an order that depends on nothing but the config, so that a resumed run sees
//! the same.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use burn::data::dataloader::{DataLoader, DataLoaderIterator, Progress};
use burn::data::dataset::DatasetError;
use burn::tensor::{Device, Tensor, TensorData};
use evpose_core::seed_for;
use evpose_nn::BodyTargets;
use evpose_pose::body::BodyLabel;
use rayon::prelude::*;

use super::augmentation::{self, BodyView};
use super::batch::BodyBatch;
use super::frames::BodyFrames;
use super::targets::BodyGrid;
use crate::order::SampleOrder;
use crate::passes::{Passes, TrainingSpan};
use crate::prefetch::Prefetch;
use crate::waiting::{DataWait, WaitMeter};
use evpose_task::body::BodyConfig;
use evpose_task::body::{BodyAugmentation, Interpolation};

/// Channels of the network's input, all the same.
const CHANNELS: usize = 3;
/// Pixels of the input for each cell of the maps.
const CELL_PX: usize = 4;

/// Images with targets and labels.
#[derive(Debug, Clone)]
pub(super) struct BodyItem {
    /// `[batch, 3, side, side]`, 0 to 255.
    pub(super) images: Tensor<4>,
    pub(super) targets: BodyTargets,
    pub(super) labels: Vec<BodyLabel>,
    /// Optimiser step this batch is for, from 1.
    pub(super) step: u64,
}

/// Images as batches for Burn.
#[derive(Clone)]
pub(super) struct BodyLoader {
    data: Arc<BodyFrames>,
    batch_size: usize,
    side_px: usize,
    seed: u64,
    order: SampleOrder,
    grid: Arc<BodyGrid>,
    augmentation: Arc<BodyAugmentation>,
    interpolation: Interpolation,
    passes: Passes,
    meter: Option<WaitMeter>,
    device: Device,
}

impl BodyLoader {
    fn new(data: Arc<BodyFrames>, config: &BodyConfig, passes: Passes, device: Device) -> Self {
        let side_px = config.image.side_px;
        Self {
            order: SampleOrder::new(data.len() as u64, seed_for(config.seed, "body order", 0)),
            data,
            batch_size: config.training.batch_size,
            side_px,
            seed: seed_for(config.seed, "body views", 0),
            grid: Arc::new(BodyGrid::new(side_px / CELL_PX, config.targets.parity)),
            augmentation: Arc::new(config.augmentation.clone()),
            interpolation: config.image.interpolation,
            passes,
            meter: None,
            device,
        }
    }

    /// Batches for training, starting with interval `interval` (from 1).
    pub(super) fn training(
        data: Arc<BodyFrames>,
        config: &BodyConfig,
        (interval, span): (usize, TrainingSpan),
        device: Device,
        meter: WaitMeter,
    ) -> Self {
        let passes = Passes::training(interval, span);
        Self { meter: Some(meter), ..Self::new(data, config, passes, device) }
    }

    /// The same batches at every validation.
    pub(super) fn validation(data: Arc<BodyFrames>, config: &BodyConfig, device: Device) -> Self {
        let samples = config.training.validation_samples.min(data.len() as u64);
        Self::new(data, config, Passes::Validation { samples }, device)
    }

    /// The image of the sample at a position, and its view.
    fn view(&self, position: u64) -> (usize, BodyView) {
        match self.passes {
            Passes::Training { .. } => {
                let index = self.order.at(position) as usize;
                let label = &self.data.frames[index].label;
                (index, augmentation::draw(&self.augmentation, self.seed, position, label))
            }
            Passes::Validation { samples } => {
                let index = (position * self.data.len() as u64 / samples) as usize;
                let label = &self.data.frames[index].label;
                (index, BodyView::plain(label, self.interpolation))
            }
        }
    }

    fn host_batch(&self, positions: Range<u64>) -> HostBatch {
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
                let (index, view) = self.view(positions.start + k as u64);
                let (first, others) = image.split_at_mut(pixels);
                view.render(&self.data.frames[index].image, self.side_px, first);
                others.chunks_mut(pixels).for_each(|channel| channel.copy_from_slice(first));
                self.grid.write(view.label(), &mut targets);
                view.label().clone()
            })
            .collect();
        HostBatch { images, batch, labels }
    }

    fn item(&self, host: HostBatch, step: u64) -> BodyItem {
        let shape = [host.labels.len(), CHANNELS, self.side_px, self.side_px];
        BodyItem {
            images: Tensor::from_data(TensorData::new(host.images, shape), &self.device),
            targets: host.batch.into_tensors(&self.device),
            labels: host.labels,
            step,
        }
    }
}

/// A batch in the memory of the host, not yet on the device.
struct HostBatch {
    images: Vec<f32>,
    batch: BodyBatch,
    labels: Vec<BodyLabel>,
}

/// A pass in progress.
struct Batches<'a> {
    loader: &'a BodyLoader,
    interval: usize,
    pass: Range<u64>,
    next: u64,
    batches: Prefetch<HostBatch>,
    started: Instant,
}

impl Iterator for Batches<'_> {
    type Item = Result<BodyItem, DatasetError>;

    fn next(&mut self) -> Option<Self::Item> {
        let batch = self.batches.next()?;
        self.next += batch.labels.len() as u64;
        let step = self.next / self.loader.batch_size as u64;
        Some(Ok(self.loader.item(batch, step)))
    }
}

impl Drop for Batches<'_> {
    fn drop(&mut self) {
        if let Some(meter) = &self.loader.meter {
            let wait = DataWait { training: self.started.elapsed(), waited: self.batches.waited() };
            meter.add(self.interval, wait);
        }
    }
}

impl DataLoaderIterator<BodyItem> for Batches<'_> {
    fn progress(&self) -> Progress {
        let items = |end: u64| (end - self.pass.start) as usize;
        Progress::new(items(self.next), items(self.pass.end), Some("samples".to_owned()))
    }
}

impl DataLoader<BodyItem> for BodyLoader {
    fn iter<'a>(&'a self) -> Box<dyn DataLoaderIterator<BodyItem> + 'a> {
        let (interval, pass) = self.passes.start();
        let (loader, end) = (self.clone(), pass.end);
        let starts = pass.clone().step_by(self.batch_size);
        let size = self.batch_size as u64;
        let batches = Prefetch::new(
            starts.map(move |start| loader.host_batch(start..(start + size).min(end))),
        );
        Box::new(Batches {
            loader: self,
            interval,
            next: pass.start,
            pass,
            batches,
            started: Instant::now(),
        })
    }

    fn num_items(&self) -> usize {
        self.passes.samples() as usize
    }

    fn to_device(&self, device: &Device) -> Arc<dyn DataLoader<BodyItem>> {
        Arc::new(Self { device: device.clone(), ..self.clone() })
    }

    /// Bodies train on one device.
    fn slice(&self, _: usize, _: usize) -> Arc<dyn DataLoader<BodyItem>> {
        Arc::new(self.clone())
    }
}
