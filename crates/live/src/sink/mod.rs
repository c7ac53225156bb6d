//! Where poses go: each sink on a thread of its own, behind a queue with a bound.

mod json;
mod table;

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::thread::JoinHandle;

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

/// All sinks of a pipeline.
#[derive(Default)]
pub struct Sinks {
    sinks: Vec<Running>,
}

struct Running {
    name: String,
    poses: SyncSender<Arc<LivePose>>,
    thread: JoinHandle<io::Result<()>>,
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
        let thread = std::thread::spawn(move || work(&mut sink, &waiting));
        self.sinks.push(Running { name, poses, thread, dropped: 0, is_gone: false });
    }

    /// Gives every sink a pose. Returns how many of them had no room for it.
    pub fn give(&mut self, pose: &Arc<LivePose>) -> u64 {
        let mut dropped = 0;
        for sink in &mut self.sinks {
            match sink.poses.try_send(pose.clone()) {
                Ok(()) => {}
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
    /// The first sink that failed; the others have written everything.
    pub fn finish(self) -> Result<Vec<(String, u64)>, LiveError> {
        let (mut told, mut failure) = (Vec::new(), None);
        for Running { name, poses, thread, dropped, .. } in self.sinks {
            drop(poses);
            let ended = thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            if let Err(source) = ended {
                failure.get_or_insert(LiveError::Sink { sink: name.clone(), source });
            }
            told.push((name, dropped));
        }
        failure.map_or(Ok(told), Err)
    }
}

fn work(sink: &mut dyn Sink, poses: &Receiver<Arc<LivePose>>) -> io::Result<()> {
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
            Some(pose) => sink.take(&pose)?,
            None => return sink.finish(),
        }
    }
}
