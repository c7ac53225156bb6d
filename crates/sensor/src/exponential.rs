//! `exp(x) - 1` that compilers turn into vector instructions.
//!
//! Filters need the part of a step that a time constant leaves over: `1 - exp(-dt / tau)`, correct
//! also where it is a millionth.
//!
//! # Model
//! `x = n ln 2 + r` with whole `n` and `|r| <= ln 2 / 2`; then
//! `exp(x) - 1 = 2^n (exp(r) - 1) + (2^n - 1)`, and `exp(r) - 1` is its series up to `r^6 / 6!`.

use std::f32::consts::LOG2_E;

/// `ln 2` in two parts: the first has nine significant bits, so that its product with an exponent
/// is exact.
const LN_2_HIGH: f32 = 0.693_359_4;
const LN_2_LOW: f32 = -2.121_944_4e-4;

/// Adding and taking away 1.5 · 2²³ leaves an `f32` without fraction.
const ROUNDER: f32 = 12_582_912.0;

/// Beyond this, powers of two leave the exponent of an `f32` behind.
const LIMIT: f32 = 80.0;

/// `1 - exp(-a)` for `a >= 0`: what a decay takes away in `a` time constants. Within 2e-7 of one,
/// and within 2e-6 of itself where it is small.
#[inline(always)]
pub(crate) fn decay(a: f32) -> f32 {
    let x = if a < LIMIT { -a } else { -LIMIT };
    let rounded = x * LOG2_E + ROUNDER;
    // What `n ln 2` lacks in precision is small beside one.
    let r = x - (rounded - ROUNDER) * std::f32::consts::LN_2;
    let series = r * (1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0)));
    let small = r + r * r * (0.5 + r * (1.0 / 6.0) + r * series);
    let power = f32::from_bits(rounded.to_bits().wrapping_add(127) << 23);
    (1.0 - power) - power * small
}

/// `exp(x) - 1` for `-80 <= x <= 80`, within 2e-6 of its value; beyond, the value at the
/// limit.
#[inline(always)]
pub(crate) fn exp_m1(x: f32) -> f32 {
    // One instruction each, unlike `clamp`, which keeps what is not a number.
    let x = if x > -LIMIT { x } else { -LIMIT };
    let x = if x < LIMIT { x } else { LIMIT };
    let rounded = x * LOG2_E + ROUNDER;
    let n = rounded - ROUNDER;
    let r = (x - n * LN_2_HIGH) - n * LN_2_LOW;
    let series = r * (1.0 / 120.0 + r * (1.0 / 720.0));
    let small = r + r * r * (0.5 + r * (1.0 / 6.0 + r * (1.0 / 24.0 + series)));
    // The last bits of the rounded number are those of n, between -116 and 116: no cast, which
    // would look for what is not a number, one value at a time.
    let power = f32::from_bits(rounded.to_bits().wrapping_add(127) << 23);
    power * small + (power - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_and_large_exponents_are_accurate() {
        for k in -4000..4000 {
            let x = k as f32 * 0.01;
            let exact = f64::from(x).exp_m1();
            let error = (f64::from(exp_m1(x)) - exact).abs();
            assert!(error <= 2e-6 * exact.abs(), "{x}: {error}");
        }
        for k in 0..10_000 {
            let a = k as f32 * k as f32 * 1e-6;
            let exact = -f64::from(-a).exp_m1();
            assert!((f64::from(decay(a)) - exact).abs() <= 2e-7 + 2e-6 * exact.min(0.1), "{a}");
        }
        assert!((f64::from(decay(1e-6)) * 1e6 - 1.0).abs() < 2e-6);
        assert_eq!((decay(0.0), decay(f32::MAX)), (0.0, 1.0));
        for x in [1e-7f32, -1e-6, 3e-5, -2e-4] {
            let exact = f64::from(x).exp_m1();
            assert!((f64::from(exp_m1(x)) / exact - 1.0).abs() < 3e-7, "{x}");
        }
        assert_eq!(exp_m1(0.0), 0.0);
    }
}
