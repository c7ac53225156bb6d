//! What the processor can do at best: the measure of every kernel.

use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use super::thread_pool::ThreadPool;
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Products of a sum in one measurement, about a millisecond.
const PRODUCTS: usize = 1 << 18;
/// Measurements, of which the fastest counts: what disturbs one only makes it slower.
const TIMES: usize = 40;

/// The most products and sums that a thread_pool does in a second, in billions of either: products
/// are added up in registers, and nothing is read or written.
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
            unsafe { level.run(&Products { sums: &sums }) };
        });
        begin.elapsed().as_secs_f64()
    };
    let fastest_s = (0..TIMES).map(|_| once()).fold(f64::INFINITY, f64::min);
    let products = PRODUCTS * sums.into_inner() * LANES * thread_pool.threads();
    2e-9 * products as f64 / fastest_s
}

struct Products<'a> {
    /// How many sums were in the making at a time: those of a tile of one block of channels.
    sums: &'a AtomicUsize,
}

impl Kernel for Products<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        self.sums.store(V::TILE[0], Ordering::Relaxed);
        // SAFETY: the caller's.
        unsafe {
            match V::TILE[0] {
                12 => products::<V, 12>(),
                6 => products::<V, 6>(),
                3 => products::<V, 3>(),
                other => unreachable!("a tile of {other} pixels is missing here"),
            }
        }
    }
}

/// # Safety
/// The processor has the instructions of `V`.
#[inline(always)]
unsafe fn products<V: Lanes, const N: usize>() {
    // SAFETY: the caller's; what is written is an array of as many numbers.
    unsafe {
        let [factor, other] = black_box([0.5_f32, 0.25]).map(|value| V::splat(value));
        let mut sums = [V::splat(0.0); N];
        for _ in 0..PRODUCTS {
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
    fn a_peak_is_that_of_a_processor_not_of_a_loop_that_was_left_out() {
        for level in Level::available() {
            let one = peak_gflop_per_s(&ThreadPool::new(1), level);
            // However slow the machine is; a loop that was left out would take no time.
            assert!((0.01..1000.0).contains(&one), "{level}: {one}");
        }
    }
}
