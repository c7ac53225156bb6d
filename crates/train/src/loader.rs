//! Batches in an order that depends on nothing but the config, so that a resumed run sees the same.
//!
//! Devices that train together share every batch: of N devices, each takes an Nth of its windows.
//! So a step is the same windows on any number of devices, and all devices take equally many steps.
//!
//! Windows are read and drawn on a thread of their own, a few batches ahead, while the network
//! works on an earlier batch.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use burn::data::dataloader::{DataLoader, DataLoaderIterator, Progress};
use burn::data::dataset::DatasetError;
use burn::tensor::{Device, Tensor, TensorData};
use rayon::prelude::*;

use crate::barrier::StepBarrier;
use crate::dataset::{HandDataset, Sample, SampleError};
use crate::hand_loss::HandBatch;
use crate::passes::{Passes, TrainingSpan};
use crate::prefetch::Prefetch;
use crate::training::StepBatch;
use crate::waiting::{DataWait, WaitMeter};

/// The part of every batch that a device takes.
#[derive(Debug, Clone, Copy)]
struct Share {
    device: u64,
    devices: u64,
}

impl Share {
    const WHOLE: Self = Self { device: 0, devices: 1 };

    /// The part of `batch` that is this share.
    fn select(self, batch: &Range<u64>) -> Range<u64> {
        let length = batch.end - batch.start;
        let at = |device: u64| batch.start + length * device / self.devices;
        at(self.device)..at(self.device + 1)
    }
}

/// A data set as batches for Burn.
#[derive(Debug, Clone)]
pub(crate) struct HandLoader {
    data: Arc<HandDataset>,
    batch_size: usize,
    passes: Passes,
    share: Share,
    /// Number of shares that Burn cuts this loader into.
    devices: u64,
    /// The barrier of the devices before each batch.
    barrier: Option<Arc<StepBarrier>>,
    /// Number of loaders that one thread waits for in turn, this one included.
    in_turn: u32,
    meter: Option<WaitMeter>,
    device: Device,
}

impl HandLoader {
    /// Batches for training, starting with interval `interval` (from 1).
    pub(crate) fn training(
        data: Arc<HandDataset>,
        interval: usize,
        span: TrainingSpan,
        device: Device,
    ) -> Self {
        Self::new(data, span.batch_size, Passes::training(interval, span), device)
    }

    /// The same batches at every validation.
    pub(crate) fn validation(
        data: Arc<HandDataset>,
        batch_size: usize,
        samples: u64,
        device: Device,
    ) -> Self {
        let samples = samples.min(data.len());
        Self::new(data, batch_size, Passes::Validation { samples }, device)
    }

    fn new(data: Arc<HandDataset>, batch_size: usize, passes: Passes, device: Device) -> Self {
        Self {
            data,
            batch_size,
            passes,
            share: Share::WHOLE,
            devices: 1,
            barrier: None,
            in_turn: 1,
            meter: None,
            device,
        }
    }

    /// Reports to `meter` how long the network waits for batches.
    pub(crate) fn metered(self, meter: WaitMeter) -> Self {
        Self { meter: Some(meter), ..self }
    }

    /// For `devices` devices, among which Burn will slice it. Those that reduce gradients among
    /// themselves have a thread each and need a `barrier`; without, one thread asks for all.
    pub(crate) fn shared_by(self, devices: usize, barrier: Option<StepBarrier>) -> Self {
        let in_turn = if barrier.is_some() { 1 } else { devices as u32 };
        Self { devices: devices as u64, barrier: barrier.map(Arc::new), in_turn, ..self }
    }
}

/// A batch in the memory of the host, not yet on the device.
struct Windows {
    inputs: Vec<f32>,
    poses: Vec<f32>,
    count: usize,
}

/// A pass in progress.
struct Batches<'a> {
    loader: &'a HandLoader,
    /// The pass, from 1.
    interval: usize,
    /// All samples of the pass, those of other devices included.
    pass: Range<u64>,
    /// Position of the next batch.
    next: u64,
    windows: Prefetch<Result<Windows, SampleError>>,
    started: Instant,
}

impl HandLoader {
    /// Positions of the batch that begins at `start`, those of other devices included.
    fn whole(&self, start: u64, pass: &Range<u64>) -> Range<u64> {
        start..(start + self.batch_size as u64).min(pass.end)
    }

    /// How many of the samples between two batch boundaries, or a boundary and the end, are this
    /// share's.
    fn shared_items(&self, samples: u64) -> u64 {
        let size = self.batch_size as u64;
        let length = |batch: u64| {
            let share = self.share.select(&(0..batch));
            share.end - share.start
        };
        samples / size * length(size) + length(samples % size)
    }

    fn sample(&self, position: u64) -> Result<Sample, SampleError> {
        match self.passes {
            Passes::Training { .. } => self.data.training_sample(position),
            Passes::Validation { samples } => {
                self.data.plain_sample(position * self.data.len() / samples)
            }
        }
    }

    fn windows(&self, positions: Range<u64>) -> Result<Windows, SampleError> {
        let samples: Vec<Sample> =
            positions.into_par_iter().map(|p| self.sample(p)).collect::<Result<_, _>>()?;
        let count = samples.len();
        let mut inputs = Vec::with_capacity(samples.iter().map(|s| s.input.len()).sum());
        let rotation = self.data.rotation();
        let mut poses = Vec::with_capacity(count * rotation.outputs());
        for sample in &samples {
            inputs.extend_from_slice(&sample.input);
            rotation.push_targets(&sample.pose, &mut poses);
        }
        Ok(Windows { inputs, poses, count })
    }

    fn batch(&self, Windows { inputs, poses, count }: Windows) -> HandBatch {
        let (height, width) = self.data.sample_size();
        let inputs = TensorData::new(inputs, [count, 2, height, width]);
        let outputs = self.data.rotation().outputs();
        HandBatch {
            inputs: Tensor::from_data(inputs, &self.device),
            poses: Tensor::from_data(TensorData::new(poses, [count, outputs]), &self.device),
        }
    }
}

impl Iterator for Batches<'_> {
    type Item = Result<StepBatch<HandBatch>, DatasetError>;

    fn next(&mut self) -> Option<Self::Item> {
        let windows = self.windows.next()?;
        self.next = self.loader.whole(self.next, &self.pass).end;
        let step = self.next / self.loader.batch_size as u64;
        // Read first: a device that has no batch must not go to the barrier.
        if windows.is_ok()
            && let Some(barrier) = &self.loader.barrier
            && !barrier.wait()
        {
            self.next = self.pass.end;
            return None;
        }
        let batch = windows.map(|windows| StepBatch { batch: self.loader.batch(windows), step });
        Some(batch.map_err(DatasetError::new))
    }
}

impl Drop for Batches<'_> {
    fn drop(&mut self) {
        if let Some(meter) = &self.loader.meter {
            let training = self.started.elapsed() / self.loader.in_turn;
            meter.add(self.interval, DataWait { training, waited: self.windows.waited() });
        }
    }
}

impl DataLoaderIterator<StepBatch<HandBatch>> for Batches<'_> {
    fn progress(&self) -> Progress {
        let items = |end: u64| self.loader.shared_items(end - self.pass.start) as usize;
        Progress::new(items(self.next), items(self.pass.end), Some("samples".to_owned()))
    }
}

impl DataLoader<StepBatch<HandBatch>> for HandLoader {
    fn iter<'a>(&'a self) -> Box<dyn DataLoaderIterator<StepBatch<HandBatch>> + 'a> {
        let (interval, pass) = self.passes.start();
        let (loader, end) = (self.clone(), pass.clone());
        let starts = pass.clone().step_by(self.batch_size);
        let windows = Prefetch::new(starts.map(move |start| {
            let whole = loader.whole(start, &end);
            loader.windows(loader.share.select(&whole))
        }));
        let (next, started) = (pass.start, Instant::now());
        Box::new(Batches { loader: self, interval, pass, next, windows, started })
    }

    fn num_items(&self) -> usize {
        self.shared_items(self.passes.samples()) as usize
    }

    fn to_device(&self, device: &Device) -> Arc<dyn DataLoader<StepBatch<HandBatch>>> {
        Arc::new(Self { device: device.clone(), ..self.clone() })
    }

    /// Burn cuts a loader into one run of items for each device; of them, only the number matters
    /// here.
    fn slice(&self, start: usize, _: usize) -> Arc<dyn DataLoader<StepBatch<HandBatch>>> {
        let device = start as u64 * self.devices / self.passes.samples();
        let share = Share { device, devices: self.devices };
        // Every share counts its own passes: each device iterates over its slice.
        Arc::new(Self { share, passes: self.passes.detached(), ..self.clone() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_cut_every_batch_into_parts_that_follow_each_other() {
        for devices in 1..=5 {
            for batch in [0..0, 60..64, 7..8, 128..192] {
                let mut next = batch.start;
                for device in 0..devices {
                    let share = Share { device, devices }.select(&batch);
                    assert_eq!(share.start, next);
                    next = share.end;
                }
                assert_eq!(next, batch.end, "{devices} devices, {batch:?}");
            }
        }
    }
}
