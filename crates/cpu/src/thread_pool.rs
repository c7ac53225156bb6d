//! A thread pool for parallel regions of tens of microseconds.
//!
//! A layer of a small network, or a step of a simulated sensor, takes less time than waking a
//! sleeping thread does. Worker threads
//! therefore spin for a few hundred microseconds after each region, then park: an idle pool uses no
//! processor time. On a loaded machine the scheduler preempts workers for milliseconds. The caller
//! therefore runs every part itself that no worker has started by the time its own is done, and
//! parks while it waits for a part that a worker has started, so that the preempted worker gets the
//! core.

#![allow(unsafe_code, reason = "workers call a body that they do not own; contracts at each line")]

use std::any::Any;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle, Thread};
use std::time::{Duration, Instant};

/// Time that a worker spins for the next region before it parks. The caller's serial code between
/// two layers takes less.
const WORKER_SPIN: Duration = Duration::from_micros(400);
/// Time that the caller spins for the last parts before it parks. Parts of workers that were not
/// preempted end within it.
const CALLER_SPIN: Duration = Duration::from_micros(100);
/// Polls between two readings of the clock, which costs as much as several polls.
const POLLS_PER_CLOCK_READ: u32 = 64;

/// One of `count` equal parts of a parallel region; one part runs on each thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// Index of the part, from 0.
    pub index: usize,
    /// Number of parts.
    pub count: usize,
}

impl Part {
    /// Range of this part's items out of `items`. The chunks of all parts cover `0..items` without
    /// overlap, and their lengths differ by at most one.
    pub fn chunk(self, items: usize) -> Range<usize> {
        items * self.index / self.count..items * (self.index + 1) / self.count
    }
}

/// Body of a parallel region, called once for each part.
type Body<'a> = dyn Fn(Part) + Sync + 'a;

/// Pointer to the body of the current region, without its lifetime.
#[derive(Clone, Copy)]
struct BodyPtr(*const Body<'static>);

// SAFETY: the body is `Sync`, and no thread follows the pointer after `ThreadPool::run` has
// returned.
unsafe impl Send for BodyPtr {}

/// State shared by the caller and the workers. A round is one parallel region.
#[derive(Default)]
struct Shared {
    /// Number of the current round.
    round: AtomicUsize,
    /// For each worker's part, the last round in which a thread started it: no part is started
    /// twice.
    started: Vec<AtomicUsize>,
    /// Workers' parts of the current round that have not ended.
    pending: AtomicUsize,
    body: Mutex<Option<BodyPtr>>,
    /// First panic of the current round.
    panic: Mutex<Option<Box<dyn Any + Send>>>,
    /// For each worker, whether it is parked.
    is_parked: Vec<AtomicBool>,
    /// The caller's thread while it is parked at the barrier.
    caller: Mutex<Option<Thread>>,
    is_caller_parked: AtomicBool,
    is_shut_down: AtomicBool,
}

/// A fixed number of threads, the calling thread included, that execute parallel regions.
///
/// ```
/// use std::sync::atomic::{AtomicUsize, Ordering};
/// use evpose_cpu::ThreadPool;
///
/// let thread_pool = ThreadPool::new(3);
/// let sum = AtomicUsize::new(0);
/// thread_pool.run(&|part| {
///     sum.fetch_add(part.chunk(10).sum(), Ordering::Relaxed);
/// });
/// assert_eq!(sum.into_inner(), 45);
/// ```
pub struct ThreadPool {
    shared: Arc<Shared>,
    workers: Vec<JoinHandle<()>>,
}

impl ThreadPool {
    /// Starts `threads - 1` workers; the caller of [`run`](Self::run) is the last thread.
    pub fn new(threads: usize) -> Self {
        let workers = threads.saturating_sub(1);
        let is_parked = (0..workers).map(|_| AtomicBool::new(false)).collect();
        let started = (0..workers).map(|_| AtomicUsize::new(0)).collect();
        let shared = Arc::new(Shared { is_parked, started, ..Shared::default() });
        let start = |index: usize| {
            let shared = Arc::clone(&shared);
            let part = Part { index: index + 1, count: workers + 1 };
            thread::spawn(move || worker_loop(&shared, part))
        };
        Self { workers: (0..workers).map(start).collect(), shared }
    }

    /// Number of threads, the caller's included.
    pub fn threads(&self) -> usize {
        self.workers.len() + 1
    }

    /// Calls `body` once for each part, one part per thread, and returns when all calls have
    /// returned (a barrier). Which thread runs which part is unspecified.
    ///
    /// # Panics
    /// If a call of `body` panics.
    pub fn run(&self, body: &Body<'_>) {
        let count = self.threads();
        if count == 1 {
            return body(Part { index: 0, count });
        }
        let shared = &*self.shared;
        // SAFETY: only the lifetime changes, and `run` does not return before every part has ended.
        let ptr =
            BodyPtr(unsafe { std::mem::transmute::<&Body<'_>, &'static Body<'static>>(body) });
        *lock(&shared.body) = Some(ptr);
        shared.pending.store(self.workers.len(), Ordering::Relaxed);
        let round = shared.round.fetch_add(1, Ordering::SeqCst) + 1;
        for (worker, is_parked) in self.workers.iter().zip(&shared.is_parked) {
            // Unparking is a system call: only where it is needed.
            if is_parked.load(Ordering::SeqCst) {
                worker.thread().unpark();
            }
        }
        shared.run_part(body, Part { index: 0, count });
        // Take over the parts of workers that have not woken up in time.
        for index in 1..count {
            let part = Part { index, count };
            if shared.try_start(part, round) {
                shared.run_part(body, part);
                shared.pending.fetch_sub(1, Ordering::Release);
            }
        }
        shared.wait();
        *lock(&shared.body) = None;
        let panic = lock(&shared.panic).take();
        if let Some(panic) = panic {
            resume_unwind(panic);
        }
    }
}

impl Shared {
    /// Claims a part of a round for the calling thread; false if another thread has claimed it.
    fn try_start(&self, part: Part, round: usize) -> bool {
        let started = &self.started[part.index - 1];
        let previous = round.wrapping_sub(1);
        started.compare_exchange(previous, round, Ordering::AcqRel, Ordering::Relaxed).is_ok()
    }

    /// Whether a round after `round` has begun or the pool is shut down.
    fn has_next(&self, round: usize) -> bool {
        self.round.load(Ordering::SeqCst) != round || self.is_shut_down.load(Ordering::SeqCst)
    }

    /// Runs a part; a panic is stored for the caller.
    fn run_part(&self, body: &Body<'_>, part: Part) {
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| body(part))) {
            lock(&self.panic).get_or_insert(panic);
        }
    }

    /// The caller's barrier: returns when no part is pending.
    fn wait(&self) {
        if spin_until(CALLER_SPIN, || self.pending.load(Ordering::Acquire) == 0) {
            return;
        }
        *lock(&self.caller) = Some(thread::current());
        self.is_caller_parked.store(true, Ordering::SeqCst);
        // A worker that ends the last part after this line sees that the caller is parked and
        // unparks it.
        while self.pending.load(Ordering::SeqCst) > 0 {
            thread::park();
        }
        self.is_caller_parked.store(false, Ordering::SeqCst);
    }
}

impl std::fmt::Debug for ThreadPool {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ThreadPool").field("threads", &self.threads()).finish()
    }
}

impl Drop for ThreadPool {
    fn drop(&mut self) {
        self.shared.is_shut_down.store(true, Ordering::SeqCst);
        for worker in self.workers.drain(..) {
            worker.thread().unpark();
            // `run` has already propagated panics of bodies.
            let _ = worker.join();
        }
    }
}

/// Main loop of a worker, which runs `part` of every round.
fn worker_loop(shared: &Shared, part: Part) {
    let mut round = 0;
    loop {
        if !spin_until(WORKER_SPIN, || shared.has_next(round)) {
            park_until_next(shared, part, round);
        }
        if shared.is_shut_down.load(Ordering::SeqCst) {
            return;
        }
        round = shared.round.load(Ordering::SeqCst);
        if !shared.try_start(part, round) {
            // The caller has taken this part over.
            continue;
        }
        let body = *lock(&shared.body);
        if let Some(BodyPtr(body)) = body {
            // SAFETY: `run` keeps the body alive until this part, which was started, is no longer
            // pending.
            shared.run_part(unsafe { &*body }, part);
        }
        let is_last = shared.pending.fetch_sub(1, Ordering::SeqCst) == 1;
        if is_last
            && shared.is_caller_parked.load(Ordering::SeqCst)
            && let Some(caller) = &*lock(&shared.caller)
        {
            caller.unpark();
        }
    }
}

/// Spins until a condition holds or `timeout` has passed; returns whether it holds.
fn spin_until(timeout: Duration, holds: impl Fn() -> bool) -> bool {
    let mut start = None;
    loop {
        for _ in 0..POLLS_PER_CLOCK_READ {
            if holds() {
                return true;
            }
            std::hint::spin_loop();
        }
        if start.get_or_insert_with(Instant::now).elapsed() > timeout {
            return false;
        }
    }
}

/// Parks the worker of `part` until a round after `round` has begun or the pool is shut down.
fn park_until_next(shared: &Shared, part: Part, round: usize) {
    let is_parked = &shared.is_parked[part.index - 1];
    is_parked.store(true, Ordering::SeqCst);
    // A caller that begins a round after this line sees that this worker is parked and unparks it.
    while !shared.has_next(round) {
        thread::park();
    }
    is_parked.store(false, Ordering::SeqCst);
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicU64;

    #[test]
    fn every_part_of_every_round_runs_once() {
        for threads in [1, 2, 3, 7] {
            let thread_pool = ThreadPool::new(threads);
            let done: Vec<AtomicU64> = (0..100).map(|_| AtomicU64::new(0)).collect();
            for round in 0..200 {
                thread_pool.run(&|part| {
                    for piece in part.chunk(done.len()) {
                        done[piece].fetch_add(1, Ordering::Relaxed);
                    }
                });
                if round % 50 == 0 {
                    thread::sleep(Duration::from_millis(5));
                }
            }
            assert!(done.iter().all(|done| done.load(Ordering::Relaxed) == 200), "{threads}");
        }
    }

    #[test]
    fn a_panic_is_propagated_and_the_thread_pool_stays_usable() {
        let thread_pool = ThreadPool::new(3);
        for index in 0..3 {
            let panic = catch_unwind(AssertUnwindSafe(|| {
                thread_pool.run(&|part| assert!(part.index != index, "part {index}"));
            }));
            let panic = panic.err().and_then(|panic| panic.downcast::<String>().ok());
            assert_eq!(panic.as_deref(), Some(&format!("part {index}")));
        }
        let count = AtomicUsize::new(0);
        thread_pool.run(&|_| {
            count.fetch_add(1, Ordering::Relaxed);
        });
        assert_eq!(count.into_inner(), 3);
    }
}
