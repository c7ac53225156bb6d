//! The thread pool of the process.

use std::sync::{Mutex, PoisonError};
use std::thread::{Builder, available_parallelism, scope};

use anyhow::{Context, Result};
use evpose_core::SensorSize;

/// Threads of a command beside one for each core: those of reading, of sinks, of the page.
const MORE: usize = 4;

/// Starts as many threads at once as a command may need, and ends them: a library that cannot start one panics,
/// in the midst of the work.
///
/// # Errors
/// If the system refuses one.
pub fn check_threads() -> Result<()> {
    let wanted = available_parallelism().map_or(1, usize::from) + MORE;
    let gate = Mutex::new(());
    scope(|scope| {
        // All wait at the gate, so that they are alive at the same time.
        let closed = gate.lock().unwrap_or_else(PoisonError::into_inner);
        for started in 0..wanted {
            Builder::new().spawn_scoped(scope, || drop(gate.lock())).with_context(|| {
                format!(
                    "the system lets this process start {started} threads of {wanted}: raise the limit of \
                     processes (`ulimit -u`, or that of the container)"
                )
            })?;
        }
        drop(closed);
        Ok(())
    })
}

/// Sets the number of CPU threads of the global pool, if one is given.
///
/// # Errors
/// If the pool is already running.
pub fn use_threads(threads: Option<usize>) -> Result<()> {
    if let Some(threads) = threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global()
            .context("setting the number of threads")?;
    }
    Ok(())
}

/// Threads that one simulated sensor of this size is worth: up to four, of 16,384 pixels and more.
pub fn sensor_threads(size: SensorSize) -> usize {
    rayon::current_num_threads().min(4).min(size.pixels() / 16_384).max(1)
}
