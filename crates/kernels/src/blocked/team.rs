//! Threads that share the work of one image.
//!
//! Layers of a small network take tens of microseconds, which a thread that sleeps does not wake in. Those
//! of a team look for work for as long, then sleep: nothing spins while there is nothing to do. On a busy machine
//! threads are stopped for milliseconds: a part that nobody has begun when the caller is done with its own
//! is done by the caller, and for one that was begun it sleeps, so that its core is free for the thread
//! that was stopped.

use std::any::Any;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle, Thread};
use std::time::{Duration, Instant};

/// How long a thread looks for work before it sleeps: what the caller does alone between two rounds is over by
/// then.
const LOOK_FOR_WORK: Duration = Duration::from_micros(400);
/// How long the caller looks for the end of the last parts before it sleeps: threads that nobody stopped
/// are done by then.
const LOOK_FOR_END: Duration = Duration::from_micros(100);
/// Looks between two looks at the clock.
const LOOKS: u32 = 64;

/// What one thread does of some work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// Which part, from 0.
    pub index: usize,
    /// How many parts there are.
    pub of: usize,
}

impl Part {
    /// This part of so many pieces; all parts together are all of them.
    pub fn share(self, pieces: usize) -> Range<usize> {
        pieces * self.index / self.of..pieces * (self.index + 1) / self.of
    }
}

/// What all threads do, each its part.
type Work<'a> = dyn Fn(Part) + Sync + 'a;

/// A reference to work without its lifetime.
#[derive(Clone, Copy)]
struct Job(*const Work<'static>);

// SAFETY: work is `Sync`, and nobody follows the pointer after `Team::run` has returned.
unsafe impl Send for Job {}

#[derive(Default)]
struct Shared {
    /// Goes up by one with every job.
    round: AtomicUsize,
    /// The last round that somebody began each part of, but the caller's own: no part is begun twice.
    begun: Vec<AtomicUsize>,
    /// Parts of the round, but the caller's own, that are not done.
    missing: AtomicUsize,
    job: Mutex<Option<Job>>,
    panic: Mutex<Option<Box<dyn Any + Send>>>,
    sleeping: Vec<AtomicBool>,
    /// The caller, where it sleeps until all is done.
    caller: Mutex<Option<Thread>>,
    is_caller_asleep: AtomicBool,
    is_over: AtomicBool,
}

/// Some threads, the caller's among them.
pub struct Team {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
}

impl Team {
    /// So many threads, at least the caller's own.
    pub fn new(threads: usize) -> Self {
        let others = threads.saturating_sub(1);
        let sleeping = (0..others).map(|_| AtomicBool::new(false)).collect();
        let begun = (0..others).map(|_| AtomicUsize::new(0)).collect();
        let shared = Arc::new(Shared { sleeping, begun, ..Shared::default() });
        let start = |index: usize| {
            let shared = Arc::clone(&shared);
            thread::spawn(move || work(&shared, Part { index: index + 1, of: others + 1 }))
        };
        Self { threads: (0..others).map(start).collect(), shared }
    }

    /// How many threads there are.
    pub fn threads(&self) -> usize {
        self.threads.len() + 1
    }

    /// Does all parts of `work`, each once, and returns when all are done. Which thread does which part is not
    /// said.
    ///
    /// # Panics
    /// If a part does.
    pub fn run(&self, work: &Work<'_>) {
        let of = self.threads();
        if of == 1 {
            return work(Part { index: 0, of });
        }
        let shared = &*self.shared;
        // SAFETY: only the lifetime changes, and `run` does not return before every part is done.
        let job = Job(unsafe { std::mem::transmute::<&Work<'_>, &'static Work<'static>>(work) });
        *lock(&shared.job) = Some(job);
        shared.missing.store(self.threads.len(), Ordering::Relaxed);
        let round = shared.round.fetch_add(1, Ordering::SeqCst) + 1;
        for (thread, sleeping) in self.threads.iter().zip(&shared.sleeping) {
            if sleeping.load(Ordering::SeqCst) {
                thread.thread().unpark();
            }
        }
        shared.part(work, Part { index: 0, of });
        for index in 1..of {
            let part = Part { index, of };
            if shared.begins(part, round) {
                shared.part(work, part);
                shared.missing.fetch_sub(1, Ordering::Release);
            }
        }
        shared.wait();
        *lock(&shared.job) = None;
        let panic = lock(&shared.panic).take();
        if let Some(panic) = panic {
            resume_unwind(panic);
        }
    }
}

impl Shared {
    /// Whether this thread, and no other, is to do a part of a round.
    fn begins(&self, part: Part, round: usize) -> bool {
        let begun = &self.begun[part.index - 1];
        let before = round.wrapping_sub(1);
        begun.compare_exchange(before, round, Ordering::AcqRel, Ordering::Relaxed).is_ok()
    }

    /// Whether there is a round behind `round`, or the end.
    fn has_more(&self, round: usize) -> bool {
        self.round.load(Ordering::SeqCst) != round || self.is_over.load(Ordering::SeqCst)
    }

    fn part(&self, work: &Work<'_>, part: Part) {
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| work(part))) {
            lock(&self.panic).get_or_insert(panic);
        }
    }

    /// Returns when no part is missing.
    fn wait(&self) {
        if look_for(LOOK_FOR_END, || self.missing.load(Ordering::Acquire) == 0) {
            return;
        }
        *lock(&self.caller) = Some(thread::current());
        self.is_caller_asleep.store(true, Ordering::SeqCst);
        // Whoever does the last part behind this line sees that the caller sleeps.
        while self.missing.load(Ordering::SeqCst) > 0 {
            thread::park();
        }
        self.is_caller_asleep.store(false, Ordering::SeqCst);
    }
}

impl Drop for Team {
    fn drop(&mut self) {
        self.shared.is_over.store(true, Ordering::SeqCst);
        for thread in self.threads.drain(..) {
            thread.thread().unpark();
            // Its panics were passed on by `run`.
            let _ = thread.join();
        }
    }
}

/// What a thread of a team does.
fn work(shared: &Shared, part: Part) {
    let mut round = 0;
    loop {
        if !look_for(LOOK_FOR_WORK, || shared.has_more(round)) {
            sleep(shared, part, round);
        }
        if shared.is_over.load(Ordering::SeqCst) {
            return;
        }
        round = shared.round.load(Ordering::SeqCst);
        if !shared.begins(part, round) {
            // The caller does it, or has done it.
            continue;
        }
        let job = *lock(&shared.job);
        if let Some(Job(work)) = job {
            // SAFETY: `run` keeps the work until this part, which was begun, is counted as done.
            shared.part(unsafe { &*work }, part);
        }
        let is_last = shared.missing.fetch_sub(1, Ordering::SeqCst) == 1;
        if is_last
            && shared.is_caller_asleep.load(Ordering::SeqCst)
            && let Some(caller) = &*lock(&shared.caller)
        {
            caller.unpark();
        }
    }
}

/// Looks for something for so long; whether it was there.
fn look_for(time: Duration, is_there: impl Fn() -> bool) -> bool {
    let mut begin = None;
    loop {
        for _ in 0..LOOKS {
            if is_there() {
                return true;
            }
            std::hint::spin_loop();
        }
        if begin.get_or_insert_with(Instant::now).elapsed() > time {
            return false;
        }
    }
}

/// Sleeps until there is a round behind `round`, or the end.
fn sleep(shared: &Shared, part: Part, round: usize) {
    let sleeping = &shared.sleeping[part.index - 1];
    sleeping.store(true, Ordering::SeqCst);
    // Whoever begins a round behind this line sees that this thread sleeps.
    while !shared.has_more(round) {
        thread::park();
    }
    sleeping.store(false, Ordering::SeqCst);
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicU64;

    #[test]
    fn every_part_of_every_round_is_done_once() {
        for threads in [1, 2, 3, 7] {
            let team = Team::new(threads);
            let done: Vec<AtomicU64> = (0..100).map(|_| AtomicU64::new(0)).collect();
            for round in 0..200 {
                team.run(&|part| {
                    for piece in part.share(done.len()) {
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
    fn a_panic_comes_back_and_the_team_goes_on() {
        let team = Team::new(3);
        for index in 0..3 {
            let panic = catch_unwind(AssertUnwindSafe(|| {
                team.run(&|part| assert!(part.index != index, "part {index}"));
            }));
            let panic = panic.err().and_then(|panic| panic.downcast::<String>().ok());
            assert_eq!(panic.as_deref(), Some(&format!("part {index}")));
        }
        let count = AtomicUsize::new(0);
        team.run(&|_| {
            count.fetch_add(1, Ordering::Relaxed);
        });
        assert_eq!(count.into_inner(), 3);
    }
}
