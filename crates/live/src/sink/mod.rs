//! Sinks of poses: each on its own thread, behind a bounded queue.

mod json;
mod output;
mod table;

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{
    Receiver, RecvTimeoutError, SyncSender, TryRecvError, TrySendError, channel, sync_channel,
};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

pub use json::JsonLines;
pub use table::PoseCsv;

use crate::{LiveError, LivePose};

/// A consumer of poses. It runs on its own thread and may block.
pub trait Sink: Send + 'static {
    /// Name in messages.
    fn name(&self) -> String;

    /// Writes a pose.
    ///
    /// # Errors
    /// If it cannot be written; the sink is then not called again.
    fn write(&mut self, pose: &LivePose) -> io::Result<()>;

    /// Writes what is buffered; called when no pose is queued.
    ///
    /// # Errors
    /// As [`Self::write`].
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }

    /// Ends the output.
    ///
    /// # Errors
    /// As [`Self::write`].
    fn finish(&mut self) -> io::Result<()> {
        self.flush()
    }
}

/// Default capacity of a sink's queue in poses: four seconds at 1,000 poses per second.
const QUEUE_CAPACITY: usize = 4_096;

/// Time without progress after which [`Sinks::finish`] gives up on a sink.
const FINISH_TIMEOUT: Duration = Duration::from_secs(3);

/// Such times that a sink may take to end, once it has all poses.
const WAITS_FOR_DISK: u32 = 20;

/// Interval at which a full queue is tried again.
const RETRY_INTERVAL: Duration = Duration::from_millis(1);

/// All sinks of a pipeline.
pub struct Sinks {
    sinks: Vec<RunningSink>,
    timeout: Duration,
}

impl Default for Sinks {
    fn default() -> Self {
        Self { sinks: Vec::new(), timeout: FINISH_TIMEOUT }
    }
}

struct RunningSink {
    name: String,
    poses: SyncSender<Arc<LivePose>>,
    thread: JoinHandle<io::Result<()>>,
    written: Arc<AtomicU64>,
    /// Disconnects when the thread ends.
    ended: Receiver<()>,
    sent: u64,
    dropped: u64,
    has_failed: bool,
    /// Whether the sink took nothing for so long that it is not waited for again.
    is_stuck: bool,
}

impl Sinks {
    /// No sinks.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a sink.
    pub fn add(&mut self, sink: impl Sink) {
        self.add_with_capacity(sink, QUEUE_CAPACITY);
    }

    /// Adds a sink with a queue of `capacity` poses.
    pub fn add_with_capacity(&mut self, mut sink: impl Sink, capacity: usize) {
        // Bounded: a sink that is slow must not fill the memory.
        let (poses, waiting) = sync_channel(capacity);
        let name = sink.name();
        let written = Arc::<AtomicU64>::default();
        let (end, ended) = channel::<()>();
        let count = written.clone();
        let thread = std::thread::spawn(move || {
            // Dropped when the thread ends, also by a panic.
            let _end = end;
            write_all(&mut sink, &waiting, &count)
        });
        let (sent, dropped, has_failed, is_stuck) = (0, 0, false, false);
        self.sinks.push(RunningSink {
            name,
            poses,
            thread,
            written,
            ended,
            sent,
            dropped,
            has_failed,
            is_stuck,
        });
    }

    /// Sends a pose to every sink. Returns the number of sinks whose queue was full.
    pub fn send(&mut self, pose: &Arc<LivePose>) -> u64 {
        self.sinks.iter_mut().map(|sink| u64::from(!sink.send(pose, Duration::ZERO))).sum()
    }

    /// As [`Self::send`], but waits for room in full queues. A sink that takes nothing for as long
    /// as [`Self::finish`] would wait is not waited for until it does.
    pub fn send_waiting(&mut self, pose: &Arc<LivePose>) -> u64 {
        let timeout = self.timeout;
        // A sink that has been waited for once in vain is not waited for again.
        let wait = |sink: &RunningSink| if sink.is_stuck { Duration::ZERO } else { timeout };
        let mut dropped = 0;
        for sink in &mut self.sinks {
            sink.is_stuck = !sink.send(pose, wait(sink));
            dropped += u64::from(sink.is_stuck);
        }
        dropped
    }

    /// Names of the sinks that have failed.
    pub fn failed(&self) -> impl Iterator<Item = &str> {
        self.sinks.iter().filter(|sink| sink.has_failed).map(|sink| sink.name.as_str())
    }

    /// Whether there are sinks and all of them have failed.
    pub fn have_all_failed(&self) -> bool {
        !self.sinks.is_empty() && self.sinks.iter().all(|sink| sink.has_failed)
    }

    /// Waits until all poses are written. Returns the name of each sink and the number of poses
    /// that it dropped.
    ///
    /// # Errors
    /// The error of the first sink that failed or made no progress; the others have written every
    /// pose.
    pub fn finish(self) -> Result<Vec<(String, u64)>, LiveError> {
        let (mut drop_counts, mut failure) = (Vec::new(), None);
        for sink in self.sinks {
            let (name, dropped) = (sink.name.clone(), sink.dropped);
            if let Err(source) = sink.finish(self.timeout) {
                // The first failure is reported, but all sinks are ended.
                failure.get_or_insert(LiveError::Sink { sink: name.clone(), source });
            }
            drop_counts.push((name, dropped));
        }
        failure.map_or(Ok(drop_counts), Err)
    }
}

impl RunningSink {
    /// Sends a pose as soon as there is room, within `timeout`. Returns false if it was dropped.
    fn send(&mut self, pose: &Arc<LivePose>, timeout: Duration) -> bool {
        let began = Instant::now();
        loop {
            match self.poses.try_send(pose.clone()) {
                Ok(()) => {
                    self.sent += 1;
                    return true;
                }
                // `finish` returns its error.
                Err(TrySendError::Disconnected(_)) => {
                    // Done all the same: other sinks go on.
                    self.has_failed = true;
                    return true;
                }
                Err(TrySendError::Full(_)) if began.elapsed() < timeout => {
                    std::thread::sleep(RETRY_INTERVAL);
                }
                Err(TrySendError::Full(_)) => {
                    self.dropped += 1;
                    return false;
                }
            }
        }
    }

    fn finish(self, timeout: Duration) -> io::Result<()> {
        drop(self.poses);
        let (mut before, mut waits) = (self.written.load(Ordering::Relaxed), 0);
        while self.ended.recv_timeout(timeout) == Err(RecvTimeoutError::Timeout) {
            let written = self.written.load(Ordering::Relaxed);
            waits += 1;
            // Time is granted anew as long as poses are taken: a slow sink is no stuck one. Behind the last, a file may
            // wait for its disk.
            let is_draining = written >= self.sent && waits < WAITS_FOR_DISK;
            if std::mem::replace(&mut before, written) == written && !is_draining {
                let left = self.sent.saturating_sub(written);
                let message = format!(
                    "took nothing for {:.1} s and was abandoned with {left} poses queued",
                    timeout.as_secs_f64()
                );
                return Err(io::Error::new(io::ErrorKind::TimedOut, message));
            }
        }
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

fn write_all(
    sink: &mut dyn Sink,
    poses: &Receiver<Arc<LivePose>>,
    written: &AtomicU64,
) -> io::Result<()> {
    loop {
        let next = match poses.try_recv() {
            Err(TryRecvError::Empty) => {
                // A reader of a pipe or socket sees every pose at once.
                sink.flush()?;
                poses.recv().ok()
            }
            next => next.ok(),
        };
        match next {
            Some(pose) => {
                sink.write(&pose)?;
                written.fetch_add(1, Ordering::Relaxed);
            }
            // The sender is gone: everything is written.
            None => return sink.finish(),
        }
    }
}
