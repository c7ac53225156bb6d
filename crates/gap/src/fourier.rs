//! Discrete Fourier transform whose length is a power of two.
//!
//! Radix two, decimation in frequency (Gentleman and Sande 1966): input is in natural order, output
//! in bit-reversed order, which [`bit_reversed`] maps back. Powers can thus be summed over blocks
//! before any reordering.

use std::f64::consts::TAU;
use std::sync::OnceLock;

/// Logarithm to base two of the longest transform.
const MAX_BITS: u32 = 18;
const MAX_LENGTH: usize = 1 << MAX_BITS;

/// Twiddle factors: real and imaginary parts of `exp(-2 pi i j / 2h)` for `j < h`, for every `h =
/// 1, 2, 4, ...`: those of `h` are at `h - 1 + j`.
struct Roots {
    re: Vec<f32>,
    im: Vec<f32>,
}

impl Roots {
    fn get() -> &'static Self {
        static ROOTS: OnceLock<Roots> = OnceLock::new();
        ROOTS.get_or_init(|| {
            let halves = (0..MAX_BITS).map(|bits| 1_usize << bits);
            let angles =
                halves.flat_map(|half| (0..half).map(move |j| -TAU * j as f64 / (2 * half) as f64));
            let (im, re) = angles.map(|a| (a.sin() as f32, a.cos() as f32)).unzip();
            Self { re, im }
        })
    }
}

/// A complex signal and, after [`Fourier::transform`], its spectrum.
#[derive(Debug, Clone)]
pub(crate) struct Fourier {
    pub(crate) re: Vec<f32>,
    pub(crate) im: Vec<f32>,
}

impl Fourier {
    /// A signal of zeros with the next power of two of `length` values, up to [`MAX_LENGTH`].
    pub(crate) fn zeros(length: usize) -> Self {
        let length = length.next_power_of_two().clamp(2, MAX_LENGTH);
        Self { re: vec![0.0; length], im: vec![0.0; length] }
    }

    /// Number of values, a power of two.
    pub(crate) fn length(&self) -> usize {
        self.re.len()
    }

    pub(crate) fn clear(&mut self) {
        self.re.fill(0.0);
        self.im.fill(0.0);
    }

    /// Transforms the signal into its spectrum `sum_n z_n exp(-2 pi i k n / N)`, in reversed order.
    pub(crate) fn transform(&mut self) {
        // Dispatched to the widest SIMD registers of the processor; nothing is reordered.
        evpose_cpu::vectorize(
            #[inline(always)]
            || self.butterflies(),
        );
    }

    #[inline(always)]
    fn butterflies(&mut self) {
        let roots = Roots::get();
        let mut half = self.length() / 2;
        while half > 1 {
            // Tables of the shorter stages come first: together they have `half - 1` roots.
            let (wr, wi) = (&roots.re[half - 1..2 * half - 1], &roots.im[half - 1..2 * half - 1]);
            let blocks = self.re.chunks_exact_mut(2 * half).zip(self.im.chunks_exact_mut(2 * half));
            for (re, im) in blocks {
                let ((ar, br), (ai, bi)) = (re.split_at_mut(half), im.split_at_mut(half));
                for j in 0..half {
                    let (dr, di) = (ar[j] - br[j], ai[j] - bi[j]);
                    ar[j] += br[j];
                    ai[j] += bi[j];
                    br[j] = dr * wr[j] - di * wi[j];
                    bi[j] = dr * wi[j] + di * wr[j];
                }
            }
            half /= 2;
        }
        // The last stage: sums and differences of neighbours, whose twiddle factor is one.
        for pair in self.re.chunks_exact_mut(2).chain(self.im.chunks_exact_mut(2)) {
            (pair[0], pair[1]) = (pair[0] + pair[1], pair[0] - pair[1]);
        }
    }

    /// Real and imaginary part at frequency `k`, in cycles per signal, of the spectrum.
    pub(crate) fn at(&self, k: usize) -> [f32; 2] {
        let place = bit_reversed(k, self.length());
        [self.re[place], self.im[place]]
    }
}

/// Index of frequency `k` in a bit-reversed spectrum of `length` values.
pub(crate) fn bit_reversed(k: usize, length: usize) -> usize {
    k.reverse_bits() >> (usize::BITS - length.trailing_zeros())
}

#[cfg(test)]
mod tests {
    use evpose_core::CounterRng;
    use rustfft::num_complex::Complex32;

    use super::*;

    /// `rustfft` is the independent program.
    #[test]
    fn a_spectrum_is_that_of_another_program() {
        let mut rng = CounterRng::new(1, "fourier", 0);
        for length in [2, 8, 64, 32_768] {
            let mut signal = Fourier::zeros(length);
            signal.re.iter_mut().chain(&mut signal.im).for_each(|z| *z = rng.normal());
            let values = signal.re.iter().zip(&signal.im).map(|(re, im)| Complex32::new(*re, *im));
            let mut theirs: Vec<Complex32> = values.collect();
            rustfft::FftPlanner::new().plan_fft_forward(length).process(&mut theirs);
            signal.transform();
            let largest = theirs.iter().map(|value| value.norm()).fold(0.0, f32::max);
            for (k, value) in theirs.into_iter().enumerate() {
                let [re, im] = signal.at(k);
                let off = (Complex32::new(re, im) - value).norm();
                assert!(off < 1e-5 * largest, "{length} {k}: {off}");
            }
        }
    }
}
