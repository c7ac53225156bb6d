//! Threads that share the work of one image.
//!
//! Layers of a small network take tens of microseconds, which a thread that sleeps does not wake in. Those
//! of a team look for work for as long, then let others run, then sleep: nothing spins while there
//! is nothing to do.

use std::any::Any;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

/// Looks for work before a thread lets others run, some tens of microseconds.
const SPINS: u32 = 800;
/// Times it lets others run before it sleeps.
const YIELDS: u32 = 200;

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
    /// Threads that have not yet done their part of the round.
    missing: AtomicUsize,
    job: Mutex<Option<Job>>,
    panic: Mutex<Option<Box<dyn Any + Send>>>,
    sleeping: Vec<AtomicBool>,
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
        let shared = Arc::new(Shared { sleeping, ..Shared::default() });
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

    /// Does all parts of `work`, one in each thread, and returns when all are done.
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
        shared.round.fetch_add(1, Ordering::SeqCst);
        for (thread, sleeping) in self.threads.iter().zip(&shared.sleeping) {
            if sleeping.load(Ordering::SeqCst) {
                thread.thread().unpark();
            }
        }
        let own = catch_unwind(AssertUnwindSafe(|| work(Part { index: 0, of })));
        let mut looks = 0;
        while shared.missing.load(Ordering::Acquire) > 0 {
            pause(&mut looks);
        }
        *lock(&shared.job) = None;
        let panic = lock(&shared.panic).take();
        if let Some(panic) = own.err().or(panic) {
            resume_unwind(panic);
        }
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
    let (mut round, mut looks) = (0, 0);
    loop {
        if shared.is_over.load(Ordering::SeqCst) {
            return;
        }
        let now = shared.round.load(Ordering::Acquire);
        if now == round {
            if looks < SPINS + YIELDS {
                pause(&mut looks);
            } else {
                sleep(shared, part, round);
            }
            continue;
        }
        (round, looks) = (now, 0);
        let job = *lock(&shared.job);
        if let Some(Job(work)) = job {
            // SAFETY: `run` keeps the work until this part is counted as done.
            let work = unsafe { &*work };
            if let Err(panic) = catch_unwind(AssertUnwindSafe(|| work(part))) {
                *lock(&shared.panic) = Some(panic);
            }
        }
        shared.missing.fetch_sub(1, Ordering::Release);
    }
}

/// Sleeps until there is a round behind `round`, or the end.
fn sleep(shared: &Shared, part: Part, round: usize) {
    let sleeping = &shared.sleeping[part.index - 1];
    sleeping.store(true, Ordering::SeqCst);
    // Whoever begins a round behind this line sees that this thread sleeps.
    while shared.round.load(Ordering::SeqCst) == round && !shared.is_over.load(Ordering::SeqCst) {
        thread::park();
    }
    sleeping.store(false, Ordering::SeqCst);
}

fn pause(looks: &mut u32) {
    *looks += 1;
    if *looks < SPINS {
        std::hint::spin_loop();
    } else {
        thread::yield_now();
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicU64;
    use std::time::Duration;

    use super::*;

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
