//! Pixels that a camera loses or makes up.
//!
//! # Model
//! Each pixel draws an integer uniform in 0 to 254, of the seed and its place alone; images of one
//! size and seed draw the same.

use evpose_core::{Plane, StageNoise};
use evpose_cpu::vectorize;

/// Integers a pixel can draw: 0 to 254, as NumPy's `randint(0, 255)` of the published program.
const LEVELS: u64 = 255;

/// Bits of a draw: one less than half of a hash, so that 2³¹ is a limit as well.
const DRAW_BITS: u32 = 31;

/// Pixels that share hashes: the first half of them has the low bits, the second half the high
/// ones.
const BLOCK: usize = 64;

/// Blackens pixels that draw less than `below`: 90 in 255 of them for `below` = 90.
pub fn pepper(image: &mut Plane<u8>, below: u8, seed: u64) {
    let none_white = first_draw(LEVELS);
    speckle(image, StageNoise::new(seed, "pepper", 0), first_draw(below.into()), none_white);
}

/// Blackens pixels that draw less than `low`, and then makes those white that draw more than
/// `high`.
pub fn salt_and_pepper(image: &mut Plane<u8>, low: u8, high: u8, seed: u64) {
    let (black_below, white_from) = (first_draw(low.into()), first_draw(u64::from(high) + 1));
    speckle(image, StageNoise::new(seed, "salt and pepper", 0), black_below, white_from);
}

/// The lowest draw that stands for `level` or more, as `draw · 255 / 2³¹`.
fn first_draw(level: u64) -> u32 {
    // At most 2³¹ · 256 / 255.
    (level << DRAW_BITS).div_ceil(LEVELS) as u32
}

fn speckle(image: &mut Plane<u8>, noise: StageNoise, black_below: u32, white_from: u32) {
    let mut draws = [0; BLOCK];
    // Levels are moved in: behind a reference, each pixel written might change them.
    vectorize(
        #[inline(always)]
        move || {
            for (block, pixels) in image.data_mut().chunks_mut(BLOCK).enumerate() {
                fill(noise, block, &mut draws);
                for (pixel, &draw) in pixels.iter_mut().zip(&draws) {
                    let kept = if draw < black_below { 0 } else { *pixel };
                    *pixel = if draw >= white_from { 255 } else { kept };
                }
            }
        },
    );
}

/// The draws of a block of pixels.
#[inline(always)]
fn fill(noise: StageNoise, block: usize, draws: &mut [u32; BLOCK]) {
    let (first, second) = draws.split_at_mut(BLOCK / 2);
    for (k, (first, second)) in first.iter_mut().zip(second).enumerate() {
        let bits = noise.bits(block * (BLOCK / 2) + k, 0);
        *first = (bits as u32) >> 1;
        *second = (bits >> 33) as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 501;

    fn share(image: &Plane<u8>, value: u8) -> f64 {
        let count = image.data().iter().filter(|&&pixel| pixel == value).count();
        count as f64 / image.data().len() as f64
    }

    /// Whether a share of that many pixels is within four standard errors.
    fn near(share: f64, of_255: f64) -> bool {
        let p = of_255 / 255.0;
        (share - p).abs() <= 4.0 * (p * (1.0 - p) / (SIDE * SIDE) as f64).sqrt()
    }

    #[test]
    fn pepper_blackens_as_many_pixels_as_draw_less() {
        let mut image = Plane::filled(SIDE, SIDE, 200);
        pepper(&mut image, 90, 3);
        assert!(near(share(&image, 0), 90.0), "{}", share(&image, 0));
        assert!(near(share(&image, 200), 165.0));
    }

    #[test]
    fn salt_and_pepper_leaves_what_draws_between() {
        for (low, high) in [(5u8, 250u8), (30, 225)] {
            let mut image = Plane::filled(SIDE, SIDE, 100);
            salt_and_pepper(&mut image, low, high, 3);
            // 0 to low - 1, and high + 1 to 254.
            assert!(near(share(&image, 0), low.into()), "{}", share(&image, 0));
            assert!(near(share(&image, 255), 254.0 - f64::from(high)), "{}", share(&image, 255));
        }
    }

    #[test]
    fn extreme_levels_change_nothing_and_everything() {
        let mut image = Plane::filled(31, 31, 100);
        pepper(&mut image, 0, 1);
        salt_and_pepper(&mut image, 0, 254, 1);
        assert_eq!(share(&image, 100), 1.0);
        pepper(&mut image, 255, 1);
        assert_eq!(share(&image, 0), 1.0);
    }

    #[test]
    fn the_two_noises_and_two_seeds_are_unrelated() {
        let black = |noise: &dyn Fn(&mut Plane<u8>)| {
            let mut image = Plane::filled(SIDE, SIDE, 100);
            noise(&mut image);
            image
        };
        let one = black(&|image| pepper(image, 90, 1));
        for other in [
            black(&|image| pepper(image, 90, 2)),
            black(&|image| salt_and_pepper(image, 90, 254, 1)),
        ] {
            let both = one.data().iter().zip(other.data()).filter(|&(a, b)| *a + *b == 0).count();
            let share = both as f64 / (SIDE * SIDE) as f64;
            assert!(near(share, 90.0 * 90.0 / 255.0), "{share}");
        }
        assert_eq!(one, black(&|image| pepper(image, 90, 1)));
    }
}
