//! Batches in an order that depends on nothing but the config, so that a resumed run sees the same.
//!
//! Devices that train together share every batch: of N devices, each takes an Nth of its samples.
//! So a step is the same samples on any number of devices, and all devices take equally many steps.
//!
//! Batches are made on a thread of their own, a few ahead, while the network works on an earlier one.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use burn::data::dataloader::{DataLoader, DataLoaderIterator, Progress};
use burn::data::dataset::DatasetError;
use burn::tensor::Device;

use crate::barrier::StepBarrier;
use crate::passes::{Passes, TrainingSpan};
use crate::prefetch::Prefetch;
use crate::training::StepBatch;
use crate::waiting::{DataWait, WaitMeter};

/// Makes batches of samples: first in the memory of the host, then on a device.
pub trait BatchSource: Clone + Send + Sync + 'static {
    /// A batch in the memory of the host.
    type Host: Send + 'static;
    /// A batch on the device.
    type Item: Send + 'static;

    /// The samples at `positions` of a pass.
    ///
    /// # Errors
    /// If one cannot be read; the training ends.
    fn host_batch(
        &self,
        passes: &Passes,
        positions: Range<u64>,
    ) -> Result<Self::Host, DatasetError>;

    /// The batch on `device`.
    fn item(&self, host: Self::Host, device: &Device) -> Self::Item;
}

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
        // Shares of one bound meet there: no sample is lost or taken twice if devices do not
        // divide it.
        let length = batch.end - batch.start;
        let at = |device: u64| batch.start + length * device / self.devices;
        at(self.device)..at(self.device + 1)
    }
}

/// A source as batches for Burn.
#[derive(Clone)]
pub(crate) struct BatchLoader<S> {
    source: S,
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

impl<S: BatchSource> BatchLoader<S> {
    /// Batches for training, starting with interval `interval` (from 1). `meter` learns how long the network
    /// waits for them.
    pub(crate) fn training(
        source: S,
        (interval, span): (usize, TrainingSpan),
        device: Device,
        meter: WaitMeter,
    ) -> Self {
        let passes = Passes::training(interval, span);
        Self { meter: Some(meter), ..Self::new(source, span.batch_size, passes, device) }
    }

    /// The same batches of `samples` samples at every validation.
    pub(crate) fn validation(source: S, batch_size: usize, samples: u64, device: Device) -> Self {
        Self::new(source, batch_size, Passes::Validation { samples }, device)
    }

    fn new(source: S, batch_size: usize, passes: Passes, device: Device) -> Self {
        let (share, devices, in_turn) = (Share::WHOLE, 1, 1);
        let (barrier, meter) = (None, None);
        Self { source, batch_size, passes, share, devices, barrier, in_turn, meter, device }
    }

    /// For `devices` devices, among which Burn will slice it. Those that reduce gradients among
    /// themselves have a thread each and need a `barrier`; without, one thread asks for all.
    pub(crate) fn shared_by(self, devices: usize, barrier: Option<StepBarrier>) -> Self {
        let in_turn = if barrier.is_some() { 1 } else { devices as u32 };
        Self { devices: devices as u64, barrier: barrier.map(Arc::new), in_turn, ..self }
    }

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
}

/// A pass in progress.
struct Batches<'a, S: BatchSource> {
    loader: &'a BatchLoader<S>,
    /// The pass, from 1.
    interval: usize,
    /// All samples of the pass, those of other devices included.
    pass: Range<u64>,
    /// Position of the next batch.
    next: u64,
    batches: Prefetch<Result<S::Host, DatasetError>>,
    started: Instant,
}

impl<S: BatchSource> Iterator for Batches<'_, S> {
    type Item = Result<StepBatch<S::Item>, DatasetError>;

    fn next(&mut self) -> Option<Self::Item> {
        let batch = self.batches.next()?;
        self.next = self.loader.whole(self.next, &self.pass).end;
        let step = self.next / self.loader.batch_size as u64;
        // Read first: a device that has no batch must not go to the barrier.
        if batch.is_ok()
            && let Some(barrier) = &self.loader.barrier
            && !barrier.wait()
        {
            self.next = self.pass.end;
            return None;
        }
        let BatchLoader { source, device, .. } = self.loader;
        Some(batch.map(|batch| StepBatch { batch: source.item(batch, device), step }))
    }
}

impl<S: BatchSource> Drop for Batches<'_, S> {
    fn drop(&mut self) {
        if let Some(meter) = &self.loader.meter {
            let training = self.started.elapsed() / self.loader.in_turn;
            meter.add(self.interval, DataWait { training, waited: self.batches.waited() });
        }
    }
}

impl<S: BatchSource> DataLoaderIterator<StepBatch<S::Item>> for Batches<'_, S> {
    fn progress(&self) -> Progress {
        let items = |end: u64| self.loader.shared_items(end - self.pass.start) as usize;
        Progress::new(items(self.next), items(self.pass.end), Some("samples".to_owned()))
    }
}

impl<S: BatchSource> DataLoader<StepBatch<S::Item>> for BatchLoader<S> {
    fn iter<'a>(&'a self) -> Box<dyn DataLoaderIterator<StepBatch<S::Item>> + 'a> {
        let (interval, pass) = self.passes.start();
        let (loader, all) = (self.clone(), pass.clone());
        let starts = pass.clone().step_by(self.batch_size);
        let batches = Prefetch::new(starts.map(move |start| {
            let positions = loader.share.select(&loader.whole(start, &all));
            loader.source.host_batch(&loader.passes, positions)
        }));
        let (next, started) = (pass.start, Instant::now());
        Box::new(Batches { loader: self, interval, pass, next, batches, started })
    }

    fn num_items(&self) -> usize {
        self.shared_items(self.passes.samples()) as usize
    }

    fn to_device(&self, device: &Device) -> Arc<dyn DataLoader<StepBatch<S::Item>>> {
        Arc::new(Self { device: device.clone(), ..self.clone() })
    }

    /// Burn cuts a loader into one run of items for each device; of them, only the number matters
    /// here.
    fn slice(&self, start: usize, _: usize) -> Arc<dyn DataLoader<StepBatch<S::Item>>> {
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
