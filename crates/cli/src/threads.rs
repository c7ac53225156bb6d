//! The thread pool of the process.

use anyhow::{Context, Result};
use evpose_core::SensorSize;

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
