//! The thread of the worker: one input at a time, the newest.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};

use evpose_core::Micros;
use evpose_pose::stream::InferenceWorker;

use super::clock::Clock;
use crate::{LiveError, PacketQueue};

pub(super) struct InferenceJob<I> {
    pub(super) input: I,
    /// Time stamp of the input.
    pub(super) t: Micros,
    /// Clock that its latency is measured by.
    pub(super) clock: Clock,
    /// Index of its recording, from 0.
    pub(super) recording: u64,
}

pub(super) struct Inferred<I, O> {
    pub(super) job: InferenceJob<I>,
    pub(super) output: O,
}

/// The front end's side of the channel.
pub(super) struct InferenceHandle<I, O> {
    jobs: SyncSender<InferenceJob<I>>,
    inferred: Receiver<Result<Inferred<I, O>, LiveError>>,
    is_busy: bool,
}

/// The worker's side of the channel.
pub(super) struct InferenceThread<I, O> {
    jobs: Receiver<InferenceJob<I>>,
    inferred: SyncSender<Result<Inferred<I, O>, LiveError>>,
    queue: Arc<PacketQueue>,
}

impl<I, O> InferenceHandle<I, O> {
    /// Both sides; `queue` is nudged after every inference.
    pub(super) fn new(queue: Arc<PacketQueue>) -> (Self, InferenceThread<I, O>) {
        let (jobs, to_do) = sync_channel(1);
        let (done, inferred) = sync_channel(1);
        let handle = Self { jobs, inferred, is_busy: false };
        (handle, InferenceThread { jobs: to_do, inferred: done, queue })
    }

    /// Whether an inference is running.
    pub(super) fn is_busy(&self) -> bool {
        self.is_busy
    }

    /// Starts an inference. None may be running.
    pub(super) fn submit(&mut self, job: InferenceJob<I>) {
        self.is_busy = self.jobs.send(job).is_ok();
    }

    pub(super) fn try_finished(&mut self) -> Result<Option<Inferred<I, O>>, LiveError> {
        match self.inferred.try_recv() {
            Ok(inferred) => {
                self.is_busy = false;
                inferred.map(Some)
            }
            // Only a job that is not answered shows that the thread has ended by a fault.
            Err(TryRecvError::Disconnected) if self.is_busy => {
                Err(LiveError::Task("the network's thread has ended".into()))
            }
            Err(_) => Ok(None),
        }
    }

    /// Waits for the running inference.
    pub(super) fn wait_for_last(&mut self) -> Result<Option<Inferred<I, O>>, LiveError> {
        if !std::mem::take(&mut self.is_busy) {
            return Ok(None);
        }
        self.inferred.recv().map_or(Ok(None), |inferred| inferred.map(Some))
    }
}

impl<I, O> InferenceThread<I, O> {
    /// Infers inputs until the channel closes or the worker fails.
    pub(super) fn run(self, worker: &mut impl InferenceWorker<Input = I, Output = O>) {
        while let Ok(job) = self.jobs.recv() {
            let output = worker.infer(&job.input).map_err(LiveError::from);
            let is_failure = output.is_err();
            let inferred = output.map(|output| Inferred { job, output });
            if self.inferred.send(inferred).is_err() || is_failure {
                break;
            }
            self.queue.notify();
        }
        // Also at the end, so that nobody waits for an answer that does not come.
        self.queue.notify();
    }
}
