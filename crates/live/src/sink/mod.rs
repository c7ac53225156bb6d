//! Where poses go: each sink on a thread of its own, behind a queue with a bound.

mod json;
mod table;

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{
    Receiver, RecvTimeoutError, SyncSender, TryRecvError, TrySendError, channel, sync_channel,
};
use std::thread::JoinHandle;
use std::time::Duration;

pub use json::JsonLines;
pub use json::value as pose_as_json;
pub use table::Table;

use crate::{LiveError, LivePose};

/// Takes poses. Lives on a thread of its own, which it may hold up.
pub trait Sink: Send + 'static {
    /// What it is, for messages.
    fn name(&self) -> String;

    /// Takes a pose.
    ///
    /// # Errors
    /// If it cannot be taken; the sink is then not asked any more.
    fn take(&mut self, pose: &LivePose) -> io::Result<()>;

    /// Nothing waits: what was kept back is written.
    ///
    /// # Errors
    /// As [`Self::take`].
    fn rest(&mut self) -> io::Result<()> {
        Ok(())
    }

    /// No pose will come any more.
    ///
    /// # Errors
    /// As [`Self::take`].
    fn finish(&mut self) -> io::Result<()> {
        self.rest()
    }
}

/// Poses that wait for a sink, at most.
const MOST_WAITING: usize = 4_096;

/// A sink that takes nothing for so long is not waited for when all is over.
const PATIENCE: Duration = Duration::from_secs(3);

/// All sinks of a pipeline.
pub struct Sinks {
    sinks: Vec<Running>,
    patience: Duration,
}

impl Default for Sinks {
    fn default() -> Self {
        Self { sinks: Vec::new(), patience: PATIENCE }
    }
}

struct Running {
    name: String,
    poses: SyncSender<Arc<LivePose>>,
    thread: JoinHandle<io::Result<()>>,
    /// Poses that were taken.
    taken: Arc<AtomicU64>,
    /// Told when the thread ends.
    ended: Receiver<()>,
    given: u64,
    dropped: u64,
    is_gone: bool,
}

impl Sinks {
    /// None.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a sink.
    pub fn add(&mut self, sink: impl Sink) {
        self.add_with(sink, MOST_WAITING);
    }

    /// Adds a sink for which at most so many poses wait.
    pub fn add_with(&mut self, mut sink: impl Sink, most_waiting: usize) {
        let (poses, waiting) = sync_channel(most_waiting);
        let name = sink.name();
        let taken = Arc::<AtomicU64>::default();
        let (end, ended) = channel::<()>();
        let count = taken.clone();
        let thread = std::thread::spawn(move || {
            // Dropped when this ends, however it does.
            let _end = end;
            work(&mut sink, &waiting, &count)
        });
        let (given, dropped, is_gone) = (0, 0, false);
        self.sinks.push(Running { name, poses, thread, taken, ended, given, dropped, is_gone });
    }

    /// Gives every sink a pose. Returns how many of them had no room for it.
    pub fn give(&mut self, pose: &Arc<LivePose>) -> u64 {
        let mut dropped = 0;
        for sink in &mut self.sinks {
            match sink.poses.try_send(pose.clone()) {
                Ok(()) => sink.given += 1,
                Err(TrySendError::Full(_)) => {
                    sink.dropped += 1;
                    dropped += 1;
                }
                // It failed; what it failed of is told at the end.
                Err(TrySendError::Disconnected(_)) => sink.is_gone = true,
            }
        }
        dropped
    }

    /// The sinks that failed so far.
    pub fn gone(&self) -> impl Iterator<Item = &str> {
        self.sinks.iter().filter(|sink| sink.is_gone).map(|sink| sink.name.as_str())
    }

    /// Whether all of them failed; without any, none did.
    pub fn are_gone(&self) -> bool {
        !self.sinks.is_empty() && self.sinks.iter().all(|sink| sink.is_gone)
    }

    /// Waits until all poses are written. Returns what each sink dropped.
    ///
    /// # Errors
    /// The first sink that failed, or that takes nothing any more and is left alone; the others have written
    /// everything.
    pub fn finish(self) -> Result<Vec<(String, u64)>, LiveError> {
        let (mut told, mut failure) = (Vec::new(), None);
        for sink in self.sinks {
            let (name, dropped) = (sink.name.clone(), sink.dropped);
            if let Err(source) = sink.finish(self.patience) {
                failure.get_or_insert(LiveError::Sink { sink: name.clone(), source });
            }
            told.push((name, dropped));
        }
        failure.map_or(Ok(told), Err)
    }
}

impl Running {
    fn finish(self, patience: Duration) -> io::Result<()> {
        drop(self.poses);
        let mut before = self.taken.load(Ordering::Relaxed);
        while self.ended.recv_timeout(patience) == Err(RecvTimeoutError::Timeout) {
            let taken = self.taken.load(Ordering::Relaxed);
            if std::mem::replace(&mut before, taken) == taken {
                let left = self.given.saturating_sub(taken);
                let message = format!(
                    "took nothing for {:.1} s and was left, {left} poses with it",
                    patience.as_secs_f64()
                );
                return Err(io::Error::new(io::ErrorKind::TimedOut, message));
            }
        }
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

fn work(sink: &mut dyn Sink, poses: &Receiver<Arc<LivePose>>, taken: &AtomicU64) -> io::Result<()> {
    loop {
        let next = match poses.try_recv() {
            Err(TryRecvError::Empty) => {
                // Whoever reads along has everything that is known.
                sink.rest()?;
                poses.recv().ok()
            }
            next => next.ok(),
        };
        match next {
            Some(pose) => {
                sink.take(&pose)?;
                taken.fetch_add(1, Ordering::Relaxed);
            }
            None => return sink.finish(),
        }
    }
}
