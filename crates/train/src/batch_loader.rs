//! Batches for one device, made on a thread of their own while the network works on earlier ones.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use burn::data::dataloader::{DataLoader, DataLoaderIterator, Progress};
use burn::data::dataset::DatasetError;
use burn::tensor::Device;

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
    fn host_batch(&self, passes: &Passes, positions: Range<u64>) -> Self::Host;

    /// The batch on `device`.
    fn item(&self, host: Self::Host, device: &Device) -> Self::Item;
}

/// A source as batches for Burn.
#[derive(Clone)]
pub(crate) struct BatchLoader<S> {
    source: S,
    batch_size: usize,
    passes: Passes,
    meter: Option<WaitMeter>,
    device: Device,
}

impl<S: BatchSource> BatchLoader<S> {
    /// Batches for training, starting with interval `interval` (from 1).
    pub(crate) fn training(
        source: S,
        (interval, span): (usize, TrainingSpan),
        device: Device,
        meter: WaitMeter,
    ) -> Self {
        let passes = Passes::training(interval, span);
        Self { source, batch_size: span.batch_size, passes, meter: Some(meter), device }
    }

    /// The same batches of `samples` samples at every validation.
    pub(crate) fn validation(source: S, batch_size: usize, samples: u64, device: Device) -> Self {
        let passes = Passes::Validation { samples };
        Self { source, batch_size, passes, meter: None, device }
    }
}

/// A pass in progress.
struct Batches<'a, S: BatchSource> {
    loader: &'a BatchLoader<S>,
    interval: usize,
    pass: Range<u64>,
    next: u64,
    /// With the position behind each.
    batches: Prefetch<(u64, S::Host)>,
    started: Instant,
}

impl<S: BatchSource> Iterator for Batches<'_, S> {
    type Item = Result<StepBatch<S::Item>, DatasetError>;

    fn next(&mut self) -> Option<Self::Item> {
        let (end, batch) = self.batches.next()?;
        self.next = end;
        let BatchLoader { source, batch_size, device, .. } = self.loader;
        let (batch, step) = (source.item(batch, device), end / *batch_size as u64);
        Some(Ok(StepBatch { batch, step }))
    }
}

impl<S: BatchSource> Drop for Batches<'_, S> {
    fn drop(&mut self) {
        if let Some(meter) = &self.loader.meter {
            let wait = DataWait { training: self.started.elapsed(), waited: self.batches.waited() };
            meter.add(self.interval, wait);
        }
    }
}

impl<S: BatchSource> DataLoaderIterator<StepBatch<S::Item>> for Batches<'_, S> {
    fn progress(&self) -> Progress {
        let items = |end: u64| (end - self.pass.start) as usize;
        Progress::new(items(self.next), items(self.pass.end), Some("samples".to_owned()))
    }
}

impl<S: BatchSource> DataLoader<StepBatch<S::Item>> for BatchLoader<S> {
    fn iter<'a>(&'a self) -> Box<dyn DataLoaderIterator<StepBatch<S::Item>> + 'a> {
        let (interval, pass) = self.passes.start();
        let (source, passes, last) = (self.source.clone(), self.passes.clone(), pass.end);
        let size = self.batch_size as u64;
        let starts = pass.clone().step_by(self.batch_size);
        let batches = Prefetch::new(starts.map(move |start| {
            let end = (start + size).min(last);
            (end, source.host_batch(&passes, start..end))
        }));
        let (next, started) = (pass.start, Instant::now());
        Box::new(Batches { loader: self, interval, next, pass, batches, started })
    }

    fn num_items(&self) -> usize {
        self.passes.samples() as usize
    }

    fn to_device(&self, device: &Device) -> Arc<dyn DataLoader<StepBatch<S::Item>>> {
        Arc::new(Self { device: device.clone(), ..self.clone() })
    }

    /// One device takes all of it.
    fn slice(&self, _: usize, _: usize) -> Arc<dyn DataLoader<StepBatch<S::Item>>> {
        Arc::new(self.clone())
    }
}
