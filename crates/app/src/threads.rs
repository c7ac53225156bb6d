//! The thread pool of the process.

use anyhow::{Context, Result};

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
