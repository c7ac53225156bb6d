//! Discrete Fourier transform whose length is a power of two.

use std::cell::RefCell;

use rustfft::{FftPlannerScalar, num_complex::Complex32};

/// Length of the longest transform.
const MAX_LENGTH: usize = 1 << 18;

/// A complex signal of zeros with the next power of two of `length` values, up to [`MAX_LENGTH`].
pub(crate) fn zeros(length: usize) -> Vec<Complex32> {
    vec![Complex32::ZERO; length.next_power_of_two().clamp(2, MAX_LENGTH)]
}

/// Transforms a signal into its spectrum `sum_n z_n exp(-2 pi i k n / N)`.
pub(crate) fn transform(signal: &mut [Complex32]) {
    thread_local! {
        // Not the widest instructions of the processor: reports have the same digits on all of them.
        static PLANNER: RefCell<FftPlannerScalar<f32>> = RefCell::new(FftPlannerScalar::new());
    }
    PLANNER.with_borrow_mut(|planner| planner.plan_fft_forward(signal.len())).process(signal);
}
