//! Batches in an order that depends on nothing but the config, so that a resumed run sees the same.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use burn::data::dataloader::{DataLoader, DataLoaderIterator, Progress};
use burn::data::dataset::DatasetError;
use burn::tensor::{Device, Tensor, TensorData};
use rayon::prelude::*;

use crate::dataset::{HandDataset, Sample, SampleError};
use crate::hand_task::HandBatch;

/// Which samples a pass over a [`HandLoader`] yields.
#[derive(Debug, Clone)]
pub(crate) enum Passes {
    /// Pass `i` (from 1) is validation interval `i` of a training of `steps` steps.
    Training { first: Arc<AtomicUsize>, steps: u64, steps_per_interval: u64 },
    /// Every pass is the same `samples` samples, spread evenly over the data.
    Validation { samples: u64 },
}

/// A data set as batches for Burn.
#[derive(Debug, Clone)]
pub(crate) struct HandLoader {
    data: Arc<HandDataset>,
    batch_size: usize,
    passes: Passes,
    /// Which samples of each pass, for a device that shares the work with others.
    share: Option<Range<u64>>,
    device: Device,
}

impl HandLoader {
    /// Batches for training, starting with interval `interval` (from 1).
    pub(crate) fn training(
        data: Arc<HandDataset>,
        batch_size: usize,
        (interval, steps, steps_per_interval): (usize, u64, u64),
        device: Device,
    ) -> Self {
        let first = Arc::new(AtomicUsize::new(interval));
        let passes = Passes::Training { first, steps, steps_per_interval };
        Self { data, batch_size, passes, share: None, device }
    }

    /// The same batches at every validation.
    pub(crate) fn validation(
        data: Arc<HandDataset>,
        batch_size: usize,
        samples: u64,
        device: Device,
    ) -> Self {
        let samples = samples.min(data.len());
        Self { data, batch_size, passes: Passes::Validation { samples }, share: None, device }
    }
}

struct Batches<'a> {
    loader: &'a HandLoader,
    next: u64,
    end: u64,
    start: u64,
}

impl HandLoader {
    /// Positions (in samples) of the pass that starts now.
    fn next_pass(&self) -> Range<u64> {
        let whole = match &self.passes {
            Passes::Training { first, steps, steps_per_interval } => {
                let interval = first.fetch_add(1, Ordering::SeqCst) as u64;
                let start = (interval - 1) * steps_per_interval;
                let end = (interval * steps_per_interval).min(*steps);
                start * self.batch_size as u64..end * self.batch_size as u64
            }
            Passes::Validation { samples } => 0..*samples,
        };
        match &self.share {
            Some(share) => {
                let at = |offset: u64| (whole.start + offset).min(whole.end);
                at(share.start)..at(share.end)
            }
            None => whole,
        }
    }

    fn sample(&self, position: u64) -> Result<Sample, SampleError> {
        match self.passes {
            Passes::Training { .. } => self.data.training_sample(position),
            Passes::Validation { samples } => {
                self.data.plain_sample(position * self.data.len() / samples)
            }
        }
    }

    fn batch(&self, positions: Range<u64>) -> Result<HandBatch, SampleError> {
        let step = positions.end / self.batch_size as u64;
        let samples: Vec<Sample> =
            positions.into_par_iter().map(|p| self.sample(p)).collect::<Result<_, _>>()?;
        let count = samples.len();
        let (height, width) = self.data.image_size();
        let mut surfaces = Vec::with_capacity(count * 2 * height * width);
        let mut poses = Vec::with_capacity(count * 12);
        for sample in &samples {
            surfaces.extend_from_slice(&sample.surface);
            poses.extend_from_slice(&sample.pose);
        }
        Ok(HandBatch {
            surfaces: Tensor::from_data(
                TensorData::new(surfaces, [count, 2, height, width]),
                &self.device,
            ),
            poses: Tensor::from_data(TensorData::new(poses, [count, 12]), &self.device),
            step,
        })
    }
}

impl Iterator for Batches<'_> {
    type Item = Result<HandBatch, DatasetError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.next >= self.end {
            return None;
        }
        let start = self.next;
        self.next = (start + self.loader.batch_size as u64).min(self.end);
        let batch = self.loader.batch(start..self.next);
        Some(batch.map_err(DatasetError::new))
    }
}

impl DataLoaderIterator<HandBatch> for Batches<'_> {
    fn progress(&self) -> Progress {
        let done = (self.next - self.start) as usize;
        Progress::new(done, (self.end - self.start) as usize, Some("samples".to_owned()))
    }
}

impl DataLoader<HandBatch> for HandLoader {
    fn iter<'a>(&'a self) -> Box<dyn DataLoaderIterator<HandBatch> + 'a> {
        let pass = self.next_pass();
        Box::new(Batches { loader: self, next: pass.start, start: pass.start, end: pass.end })
    }

    fn num_items(&self) -> usize {
        let whole = match &self.passes {
            Passes::Training { steps, steps_per_interval, .. } => {
                *steps_per_interval.min(steps) * self.batch_size as u64
            }
            Passes::Validation { samples } => *samples,
        };
        self.share.as_ref().map_or(whole, |s| s.end.min(whole) - s.start.min(whole)) as usize
    }

    fn to_device(&self, device: &Device) -> Arc<dyn DataLoader<HandBatch>> {
        Arc::new(Self { device: device.clone(), ..self.clone() })
    }

    fn slice(&self, start: usize, end: usize) -> Arc<dyn DataLoader<HandBatch>> {
        let mut slice = Self { share: Some(start as u64..end as u64), ..self.clone() };
        // Every share counts its own passes.
        if let Passes::Training { first, .. } = &mut slice.passes {
            *first = Arc::new(AtomicUsize::new(first.load(Ordering::SeqCst)));
        }
        Arc::new(slice)
    }
}
