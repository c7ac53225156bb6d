//! `exp(x) - 1` that compilers turn into vector instructions.
//!
//! Filters need the part of a step that a time constant leaves over: `1 - exp(-dt / tau)`, correct
//! also where it is a millionth.
//!
//! # Model
//! `x = n ln 2 + r` with whole `n` and `|r| <= ln 2 / 2`; then
//! `exp(x) - 1 = 2^n (exp(r) - 1) + (2^n - 1)`, and `exp(r) - 1` is its series up to `r^7 / 7!`.

use std::f32::consts::{LN_2, LOG2_E};

/// Adding and taking away 1.5 · 2²³ leaves an `f32` without fraction.
const ROUNDER: f32 = 12_582_912.0;

/// `exp(x) - 1` for `-80 <= x <= 80`, within a few units in the last place; beyond, the value at
/// the limit.
#[inline(always)]
pub(crate) fn exp_m1(x: f32) -> f32 {
    let x = x.clamp(-80.0, 80.0);
    let n = (x * LOG2_E + ROUNDER) - ROUNDER;
    let r = x - n * LN_2;
    let series = r * (1.0 / 120.0 + r * (1.0 / 720.0 + r * (1.0 / 5040.0)));
    let small = r + r * r * (0.5 + r * (1.0 / 6.0 + r * (1.0 / 24.0 + series)));
    // The cast is of a whole number between -116 and 116.
    let power = f32::from_bits(((n as i32 + 127) << 23) as u32);
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
        for x in [1e-7f32, -1e-6, 3e-5, -2e-4] {
            let exact = f64::from(x).exp_m1();
            assert!((f64::from(exp_m1(x)) / exact - 1.0).abs() < 3e-7, "{x}");
        }
        assert_eq!(exp_m1(0.0), 0.0);
    }
}
