//! Normal draws for a whole block of pixels.
//!
//! A draw depends on stage, tick and pixel only, as [`StageNoise`] has it, but is made of 32-bit
//! arithmetic without calls, so that one loop draws for many pixels at a time.
//!
//! # Model
//! Box and Muller: `sqrt(-2 ln u) cos(2 pi v)` with `u` and `v` from two hashes of the pixel. The
//! largest draw is 5.8.
//!
//! # Source
//! G. E. P. Box, M. E. Muller: A Note on the Generation of Random Normal Deviates, 1958. The hash
//! is `lowbias32` of C. Wellons, hash-prospector.

use evpose_core::StageNoise;

use crate::natural_log::ln;

/// Draws that fit in the fastest memory; loops go from one such piece to the next.
pub(crate) const PIECE: usize = 64;

/// Fills `draws`, one for every pixel of a block. To be called from inside a loop of
/// [`vectorize`](evpose_cpu::vectorize).
#[inline(always)]
pub(crate) fn fill_normal(noise: StageNoise, first_pixel: usize, draws: &mut [f32]) {
    let keys = noise.bits(usize::MAX >> 32, 0);
    // 32-bit hashes instead of the 64-bit generator: eight lanes hold them, and draws are vectors.
    let (radius_key, angle_key) = (keys as u32, (keys >> 32) as u32);
    let first = first_pixel as u32;
    for (index, draw) in draws.iter_mut().enumerate() {
        let pixel = first.wrapping_add(index as u32);
        let radius = unit(hash(pixel ^ radius_key));
        let turn = unit(hash(pixel ^ angle_key));
        *draw = (-2.0 * ln(radius)).sqrt() * cosine_of_turn(turn);
    }
}

#[inline(always)]
fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// In (0, 1]; the cast is of a number below 2^24, which processors convert as a signed one.
#[inline(always)]
fn unit(bits: u32) -> f32 {
    ((bits >> 8) as i32 + 1) as f32 * (1.0 / 16_777_216.0)
}

/// `cos(2 pi turn)` for `0 <= turn <= 1`, within 4e-6: the series of the sine of the distance to
/// the nearest quarter turn.
#[inline(always)]
fn cosine_of_turn(turn: f32) -> f32 {
    let z = (turn - 0.5).abs() - 0.25;
    let x = std::f32::consts::TAU * z;
    let x2 = x * x;
    let tail = 1.0 / 120.0 + x2 * (-1.0 / 5040.0 + x2 * (1.0 / 362_880.0));
    x + x * x2 * (-1.0 / 6.0 + x2 * tail)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_normal_and_independent_of_the_block() {
        let noise = StageNoise::new(3, "any", 9);
        let n = 400_000;
        let mut draws = vec![0.0; n];
        fill_normal(noise, 0, &mut draws);
        let all: Vec<f64> = draws.iter().map(|draw| f64::from(*draw)).collect();
        let moment = |p: i32| all.iter().map(|d| d.powi(p)).sum::<f64>() / n as f64;
        let bound = |variance: f64| 4.0 * (variance / n as f64).sqrt();
        assert!(moment(1).abs() < bound(1.0), "{}", moment(1));
        assert!((moment(2) - 1.0).abs() < bound(2.0), "{}", moment(2));
        assert!((moment(4) - 3.0).abs() < bound(96.0), "{}", moment(4));
        let beyond = all.iter().filter(|d| d.abs() > 3.0).count() as f64;
        assert!((beyond - 0.0027 * n as f64).abs() < 4.0 * (0.0027 * n as f64).sqrt());
        let pairs: f64 = all.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n as f64;
        assert!(pairs.abs() < bound(1.0), "neighbours are uncorrelated: {pairs}");
        let mut part = [0.0; 123];
        fill_normal(noise, 777, &mut part);
        assert_eq!(part, draws[777..900]);
    }

    #[test]
    fn the_cosine_is_that_of_the_library() {
        for k in 0..=10_000 {
            let turn = k as f32 / 10_000.0;
            let exact = (std::f64::consts::TAU * f64::from(turn)).cos();
            assert!((f64::from(cosine_of_turn(turn)) - exact).abs() < 5e-6, "{turn}");
        }
    }
}
