//! The thread of the network: one image at a time, the newest.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};

use evpose_core::Micros;

use super::clock::Clock;
use crate::{LiveError, Network, PacketQueue};

/// An image to look at.
pub(super) struct Job<I> {
    pub(super) image: I,
    /// The time that it is of.
    pub(super) t: Micros,
    /// By which its latency is told.
    pub(super) clock: Clock,
    /// Which recording it is of, counted from 0.
    pub(super) recording: u64,
}

/// An image that was looked at.
pub(super) struct Seen<I, F> {
    pub(super) job: Job<I>,
    pub(super) found: F,
}

/// The eye's side.
pub(super) struct Looker<I, F> {
    jobs: SyncSender<Job<I>>,
    seen: Receiver<Result<Seen<I, F>, LiveError>>,
    is_busy: bool,
}

/// The network's side.
pub(super) struct Desk<I, F> {
    jobs: Receiver<Job<I>>,
    seen: SyncSender<Result<Seen<I, F>, LiveError>>,
    queue: Arc<PacketQueue>,
}

impl<I, F> Looker<I, F> {
    /// Both sides; `queue` is nudged when an image was looked at.
    pub(super) fn new(queue: Arc<PacketQueue>) -> (Self, Desk<I, F>) {
        let (jobs, to_do) = sync_channel(1);
        let (done, seen) = sync_channel(1);
        (Self { jobs, seen, is_busy: false }, Desk { jobs: to_do, seen: done, queue })
    }

    /// Whether the network looks at something.
    pub(super) fn is_busy(&self) -> bool {
        self.is_busy
    }

    /// Has the network look. It must be free.
    pub(super) fn show(&mut self, job: Job<I>) {
        self.is_busy = self.jobs.send(job).is_ok();
    }

    /// What was looked at meanwhile.
    pub(super) fn seen(&mut self) -> Result<Option<Seen<I, F>>, LiveError> {
        match self.seen.try_recv() {
            Ok(seen) => {
                self.is_busy = false;
                seen.map(Some)
            }
            Err(TryRecvError::Disconnected) if self.is_busy => {
                Err(LiveError::Task("the network's thread has ended".into()))
            }
            Err(_) => Ok(None),
        }
    }

    /// Waits for what the network is looking at.
    pub(super) fn last(&mut self) -> Result<Option<Seen<I, F>>, LiveError> {
        if !std::mem::take(&mut self.is_busy) {
            return Ok(None);
        }
        self.seen.recv().map_or(Ok(None), |seen| seen.map(Some))
    }
}

impl<I, F> Desk<I, F> {
    /// Looks at images until none will come, or the network fails.
    pub(super) fn work(self, network: &mut impl Network<Image = I, Found = F>) {
        while let Ok(job) = self.jobs.recv() {
            let found = network.look(&job.image);
            let is_failure = found.is_err();
            if self.seen.send(found.map(|found| Seen { job, found })).is_err() || is_failure {
                break;
            }
            self.queue.nudge();
        }
        self.queue.nudge();
    }
}
