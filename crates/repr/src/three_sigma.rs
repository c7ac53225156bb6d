//! Counts of events as grey values: three standard deviations are white.
//!
//! # Model
//! Over the pixels that fired, with `µ` the mean of their counts and `σ² = Σ(v - µ)²/n`, at least
//! `(0.1/255)²`: a count becomes `v·255/(3σ)`, at most 255. Where all pixels fired equally often,
//! each of them is thus white.
//!
//! # Source
//! Calabrese et al., *DHP19*, CVPRW 2019; hpe-core, class `eventFrame` in Python (which keeps
//! fractions) and `varianceNormalisation` in C++ (which drops them).

use evpose_cpu::vectorize;

/// The factor from counts to grey values; sums are exact, so the order of the pixels does not
/// matter.
pub(crate) fn three_sigma_scale(counts: impl Iterator<Item = u32>) -> f64 {
    let (fired, sum, squares) = vectorize(
        #[inline(always)]
        || {
            let (mut fired, mut sum, mut squares) = (0u64, 0u64, 0u64);
            for count in counts {
                fired += u64::from(count > 0);
                sum += u64::from(count);
                // At most the square of the number of events, of which memory does not hold 2³².
                squares += u64::from(count) * u64::from(count);
            }
            (fired, sum, squares)
        },
    );
    // No pixel has fired: nothing will be scaled.
    let fired = fired.max(1);
    // n²·σ², an integer.
    let spread = u128::from(fired) * u128::from(squares) - u128::from(sum) * u128::from(sum);
    let sigma = (spread as f64).sqrt() / fired as f64;
    255.0 / (3.0 * sigma.max(0.1 / 255.0))
}

/// Writes counts as grey values, `rounded` from what they are exactly.
#[inline(always)]
pub(crate) fn write_scaled(
    out: &mut [f32],
    counts: impl Iterator<Item = u32>,
    scale: f64,
    rounded: impl Fn(f64) -> f64,
) {
    vectorize(
        #[inline(always)]
        || {
            for (out, count) in out.iter_mut().zip(counts) {
                *out = rounded(scaled(count, scale)) as f32;
            }
        },
    );
}

/// A count as a grey value.
#[inline(always)]
fn scaled(count: u32, scale: f64) -> f64 {
    (f64::from(count) * scale).min(255.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: counts 1, 1, 4 have mean 2 and deviation √2.
    #[test]
    fn three_deviations_are_white_and_pixels_that_did_not_fire_are_left_out() {
        let scale = three_sigma_scale([0, 1, 1, 0, 4].into_iter());
        let want = 255.0 / (3.0 * 2f64.sqrt());
        assert!((scale - want).abs() < 1e-12);
        assert_eq!(scaled(1, scale), scale);
        assert_eq!(scaled(5, scale), 255.0);
        assert_eq!(scaled(0, scale), 0.0);
    }

    #[test]
    fn equal_counts_are_white_and_no_events_black() {
        let scale = three_sigma_scale([2, 2, 0].into_iter());
        assert_eq!((scaled(2, scale), scaled(0, scale)), (255.0, 0.0));
        assert!(three_sigma_scale([0, 0].into_iter()).is_finite());
    }
}
