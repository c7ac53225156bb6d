//! A natural logarithm that compilers turn into vector instructions.
//!
//! One logarithm per pixel and exposure is the largest cost of a sensor chain, and the one of the
//! standard library is a call for every single value. This one has no branch and no table, and
//! gives the same bits on every machine.
//!
//! # Model
//! `x = 2^e · m` with `m` in `[√½, √2)`, then `ln x = e ln 2 + 2 artanh s` with `s = (m-1)/(m+1)`,
//! `|s| < 0.172`, and the series `artanh s = s + s³/3 + s⁵/5 + s⁷/7`, whose first term left out is
//! below 3e-8.

/// `ln 2` in two parts: the first has nine significant bits, so that its product with an exponent
/// is exact.
const LN_2_HIGH: f32 = 0.693_359_4;
const LN_2_LOW: f32 = -2.121_944_4e-4;

/// Bits of the `f32` nearest to `√½`.
const SQRT_HALF_BITS: u32 = 0x3f35_04f3;

/// Natural logarithm of a positive, normal `x`, within 1e-6 for `|ln x| < 16`.
///
/// Anything else gives a meaningless number: callers keep zero, subnormals and non-finite values
/// away.
#[inline(always)]
pub(crate) fn ln(x: f32) -> f32 {
    let bits = x.to_bits();
    // Arithmetic shift of the distance to √½: the exponent that leaves m in [√½, √2).
    let exponent = (bits.wrapping_sub(SQRT_HALF_BITS) as i32) >> 23;
    let m = f32::from_bits(bits.wrapping_sub((exponent << 23) as u32));
    let e = exponent as f32;
    let f = m - 1.0;
    let s = f / (f + 2.0);
    let s2 = s * s;
    let tail = s2 * (1.0 / 3.0 + s2 * (1.0 / 5.0 + s2 * (1.0 / 7.0)));
    e * LN_2_HIGH + (2.0 * s + (2.0 * s * tail + e * LN_2_LOW))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logarithm_is_within_a_millionth() {
        // Every 61st float with |ln x| < 16: 6.3 million of them.
        let (low, high) = ((-16f32).exp().to_bits(), 16f32.exp().to_bits());
        let worst = (low..high)
            .step_by(61)
            .map(f32::from_bits)
            .map(|x| (f64::from(ln(x)) - f64::from(x).ln()).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1e-6, "{worst}");
    }

    #[test]
    fn the_logarithm_of_one_is_zero() {
        assert_eq!(ln(1.0), 0.0);
    }

    #[test]
    fn the_logarithm_never_decreases_around_powers_of_two() {
        // Where the exponent changes, the two branches of the reduction must meet in order.
        for seam in [0.5f32.sqrt(), 2f32.sqrt(), 1.0, 2.0, 0.25 * 2f32.sqrt()] {
            let bits = seam.to_bits();
            let values: Vec<f32> =
                (bits - 200..bits + 200).step_by(8).map(|b| ln(f32::from_bits(b))).collect();
            assert!(values.is_sorted(), "{seam}");
        }
    }
}
