//! Fast Fourier transform whose length is a power of two (Cooley and Tukey 1965).

use std::f64::consts::TAU;

/// A complex number.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Complex {
    pub(super) re: f32,
    pub(super) im: f32,
}

impl Complex {
    pub(super) fn power(self) -> f64 {
        f64::from(self.re).powi(2) + f64::from(self.im).powi(2)
    }
}

/// Twiddle factors of one length.
#[derive(Debug)]
pub(super) struct Fourier {
    factors: Vec<Complex>,
}

impl Fourier {
    /// # Panics
    /// If `length` is no power of two.
    pub(super) fn new(length: usize) -> Self {
        assert!(length.is_power_of_two(), "{length} values");
        let factor = |k: usize| {
            let (im, re) = (-TAU * k as f64 / length as f64).sin_cos();
            Complex { re: re as f32, im: im as f32 }
        };
        Self { factors: (0..length / 2).map(factor).collect() }
    }

    /// `z_f = sum of z_t exp(-2 pi i f t / n)`.
    pub(super) fn transform(&self, values: &mut [Complex]) {
        let n = values.len();
        debug_assert_eq!(n, (2 * self.factors.len()).max(1));
        if n < 2 {
            return;
        }
        let shift = usize::BITS - n.trailing_zeros();
        for i in 0..n {
            // In bit-reversed order the halves of every stage lie side by side.
            let j = i.reverse_bits() >> shift;
            if i < j {
                values.swap(i, j);
            }
        }
        let mut half = 1;
        while half < n {
            let stride = n / (2 * half);
            for group in values.chunks_exact_mut(2 * half) {
                let (low, high) = group.split_at_mut(half);
                for ((a, b), w) in low.iter_mut().zip(high).zip(self.factors.iter().step_by(stride))
                {
                    let turned =
                        Complex { re: b.re * w.re - b.im * w.im, im: b.re * w.im + b.im * w.re };
                    *b = Complex { re: a.re - turned.re, im: a.im - turned.im };
                    *a = Complex { re: a.re + turned.re, im: a.im + turned.im };
                }
            }
            half *= 2;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transform_is_the_sum_that_defines_it() {
        let values: Vec<Complex> =
            (0..16).map(|t| Complex { re: (t * t % 7) as f32, im: (t * 3 % 5) as f32 }).collect();
        let mut fast = values.clone();
        Fourier::new(16).transform(&mut fast);
        for (f, found) in fast.iter().enumerate() {
            let (mut re, mut im) = (0.0, 0.0);
            for (t, value) in values.iter().enumerate() {
                let (sin, cos) = (-TAU * (f * t) as f64 / 16.0).sin_cos();
                re += f64::from(value.re) * cos - f64::from(value.im) * sin;
                im += f64::from(value.re) * sin + f64::from(value.im) * cos;
            }
            assert!((f64::from(found.re) - re).abs() < 1e-4, "{f}");
            assert!((f64::from(found.im) - im).abs() < 1e-4, "{f}");
        }
    }
}
