//! Limits of the machine, measured: arithmetic and memory.

use std::hint::black_box;
use std::time::Instant;

use evpose_infer::Level;
use evpose_kernels::blocked::{ThreadPool, peak_gflop_per_s};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use evpose_cli::progress::say;

/// Bytes that are copied, more than any cache holds.
const COPIED: usize = 256 << 20;
/// Copies, of which the fastest counts.
const REPEATS: usize = 8;

/// Limits of the machine with some number of threads.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct MachineLimits {
    pub(crate) threads: usize,
    /// Throughput of fused multiply-adds in f32 on registers, GFLOP/s.
    pub(crate) peak_gflop_per_s: f64,
    /// Bytes read and written by a copy in memory, GB/s.
    pub(crate) bandwidth_gb_per_s: f64,
}

impl MachineLimits {
    pub(crate) fn measure(threads: usize) -> Self {
        let limits = Self {
            threads,
            peak_gflop_per_s: peak_gflop_per_s(&ThreadPool::new(threads), Level::best()),
            bandwidth_gb_per_s: bandwidth_gb_per_s(threads),
        };
        say(format!(
            "limits    {}: {:.0} GFLOP/s in f32, {:.1} GB/s of memory",
            super::threads(threads),
            limits.peak_gflop_per_s,
            limits.bandwidth_gb_per_s
        ));
        limits
    }

    /// Arithmetic throughput at `intensity` operations per byte: the roofline model.
    ///
    /// # Source
    /// Williams, Waterman, Patterson: *Roofline*, Communications of the ACM 52 (4), 2009.
    pub(crate) fn roof_gflop_per_s(&self, intensity: f64) -> f64 {
        self.peak_gflop_per_s.min(intensity * self.bandwidth_gb_per_s)
    }

    /// Operations per byte from which arithmetic is the limit.
    pub(crate) fn ridge(&self) -> f64 {
        self.peak_gflop_per_s / self.bandwidth_gb_per_s
    }
}

/// Bytes that a copy reads and writes in a second, in 1e9.
fn bandwidth_gb_per_s(threads: usize) -> f64 {
    // The source is ones: untouched zeros are all mapped to one page, which a cache holds.
    let from = vec![1_u8; COPIED];
    let mut to = vec![0_u8; COPIED];
    let share = COPIED.div_ceil(threads);
    let mut fastest_s = f64::INFINITY;
    for _ in 0..REPEATS {
        let begin = Instant::now();
        to.par_chunks_mut(share)
            .zip(from.par_chunks(share))
            // A part is a job: two parts in one job would leave a thread idle.
            .with_max_len(1)
            .for_each(|(to, from)| to.copy_from_slice(from));
        // The fastest: a limit is what the machine can do, and everything else slows it down.
        fastest_s = fastest_s.min(begin.elapsed().as_secs_f64());
        black_box(&to);
    }
    // Each byte is read and written.
    2e-9 * COPIED as f64 / fastest_s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_roof_rises_to_the_ridge_and_is_flat_behind_it() {
        let limits =
            MachineLimits { threads: 1, peak_gflop_per_s: 100.0, bandwidth_gb_per_s: 20.0 };
        assert!((limits.ridge() - 5.0).abs() < 1e-12);
        assert!((limits.roof_gflop_per_s(2.0) - 40.0).abs() < 1e-12);
        assert!((limits.roof_gflop_per_s(50.0) - 100.0).abs() < 1e-12);
    }
}
