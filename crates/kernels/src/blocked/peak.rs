//! Peak throughput of the processor in fused multiply-adds, against which kernels are measured.

use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use super::ThreadPool;
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Fused multiply-adds per accumulator in one measurement, about a millisecond.
const FMAS_PER_SUM: usize = 1 << 18;
/// Measurements, of which the fastest counts: interference only makes a measurement slower.
const REPEATS: usize = 40;

/// Measured peak of a thread pool in GFLOP/s (a fused multiply-add is two operations): a loop of
/// independent fused multiply-adds on registers, without loads and stores.
///
/// # Panics
/// If the processor does not have the instructions of `level`.
pub fn peak_gflop_per_s(thread_pool: &ThreadPool, level: Level) -> f64 {
    assert!(Level::available().contains(&level), "{level} on this processor");
    let sums = AtomicUsize::new(0);
    let once = || {
        let begin = Instant::now();
        thread_pool.run(&|_| {
            // SAFETY: the level is one of this processor's.
            unsafe { level.run(&FmaLoop { sums: &sums }) };
        });
        begin.elapsed().as_secs_f64()
    };
    let fastest_s = (0..REPEATS).map(|_| once()).fold(f64::INFINITY, f64::min);
    let fmas = FMAS_PER_SUM * sums.into_inner() * LANES * thread_pool.threads();
    2e-9 * fmas as f64 / fastest_s
}

/// Kernel of one measurement.
struct FmaLoop<'a> {
    /// Receives the number of independent accumulators: those of a tile of one channel block,
    /// enough to hide the latency of a fused multiply-add.
    sums: &'a AtomicUsize,
}

impl Kernel for FmaLoop<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        self.sums.store(V::TILE[0], Ordering::Relaxed);
        // SAFETY: the caller's.
        unsafe {
            match V::TILE[0] {
                12 => fma_loop::<V, 12>(),
                6 => fma_loop::<V, 6>(),
                3 => fma_loop::<V, 3>(),
                other => unreachable!("a tile of {other} pixels is missing here"),
            }
        }
    }
}

/// Adds up fused multiply-adds in `N` accumulators.
///
/// # Safety
/// The processor has the instructions of `V`.
#[inline(always)]
unsafe fn fma_loop<V: Lanes, const N: usize>() {
    // SAFETY: the caller's; `written` has room for a vector.
    unsafe {
        // Opaque operands and results, so that LLVM can neither fold nor remove the loop.
        let [factor, other] = black_box([0.5_f32, 0.25]).map(|value| V::splat(value));
        let mut sums = [V::splat(0.0); N];
        for _ in 0..FMAS_PER_SUM {
            for sum in &mut sums {
                *sum = factor.mul_add(other, *sum);
            }
        }
        let mut written = [0.0_f32; LANES];
        for sum in sums {
            sum.store(written.as_mut_ptr());
            black_box(&written);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_is_plausible_so_the_loop_was_not_optimised_away() {
        for level in Level::available() {
            let one = peak_gflop_per_s(&ThreadPool::new(1), level);
            // A loop that was optimised away would take no time.
            assert!((0.01..1000.0).contains(&one), "{level}: {one}");
        }
    }
}
