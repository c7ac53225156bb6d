//! Exponential fading, for many values at once.
//!
//! # Model
//! `exp(-age/τ)` is `2^k · 2^r` with an integer `k` and `r` of -0.5 to 0.5, separated in `f64`. `2^r`
//! is a Taylor polynomial of degree 7, whose remainder is less than 6e-9 of it, in `f32`, and `2^k`
//! is added to the exponent. Only sums and products, of the same bits on every processor: the
//! result is the `f32` nearest to the exact value, or the one next to it. What is below 2^-125 is
//! nothing.

/// Rounds to integers what is added to it, and has them in its lowest bits.
const ROUNDING: f64 = (3_u64 << 51) as f64;
/// The smallest power of two.
const SMALLEST: f64 = -125.0;
/// Bit offset of the exponent of an `f32`.
const EXPONENT: u32 = 23;
/// Coefficients of `2^r`: powers of the logarithm of 2 by factorials.
const COEFFICIENTS: [f32; 8] = coefficients();

const fn coefficients() -> [f32; 8] {
    let mut values = [1.0; 8];
    let (mut n, mut value) = (1, 1.0);
    while n < values.len() {
        value *= std::f64::consts::LN_2 / n as f64;
        values[n] = value as f32;
        n += 1;
    }
    values
}

/// Fading by `e` in a time constant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fade {
    /// Logarithm to base 2 of what is left after a microsecond.
    per_us: f64,
}

impl Fade {
    /// Fading with this time constant, above 0.
    pub(crate) fn new(tau_us: f64) -> Self {
        Self { per_us: -std::f64::consts::LOG2_E / tau_us }
    }

    /// Remainder of 1 after `age_us`, from 0 on.
    #[inline(always)]
    pub(crate) fn after(self, age_us: i32) -> f32 {
        let power = f64::from(age_us) * self.per_us;
        // A product, not a branch: no vector takes both ways of one.
        let is_left = f32::from(u8::from(power > SMALLEST));
        let power = if power < SMALLEST { SMALLEST } else { power };
        let rounded = power + ROUNDING;
        let rest = (power - (rounded - ROUNDING)) as f32;
        let mut value = COEFFICIENTS[7];
        for coefficient in COEFFICIENTS.iter().rev().skip(1) {
            value = value * rest + coefficient;
        }
        let exponent = (rounded.to_bits() as u32) << EXPONENT;
        f32::from_bits(value.to_bits().wrapping_add(exponent)) * is_left
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_nearest_to_the_exponential_or_next_to_it() {
        for tau_us in [1.0, 700.0, 30_000.0, 1e9] {
            let fade = Fade::new(tau_us);
            assert_eq!(fade.after(0), 1.0);
            for age_us in (0..2_000_000).step_by(7).chain((0..=1 << 30).step_by(1_000_003)) {
                let want = (-f64::from(age_us) / tau_us).exp() as f32;
                let apart = fade.after(age_us).to_bits().abs_diff(want.to_bits());
                let is_nothing = fade.after(age_us) == 0.0 && want < 2.4e-38;
                assert!(
                    apart <= 1 || is_nothing,
                    "{age_us} of {tau_us}: {} {want}",
                    fade.after(age_us)
                );
            }
        }
    }
}
