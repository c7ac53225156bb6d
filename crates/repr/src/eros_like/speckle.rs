//! Pixels that a camera loses or makes up.
//!
//! # Model
//! Each pixel draws an integer uniform in 0 to 254, of the seed and its place alone; images of one
//! size and seed draw the same.

use evpose_core::{Plane, StageNoise, wide};

/// Integers a pixel can draw: 0 to 254, as NumPy's `randint(0, 255)` of the published program.
const LEVELS: u64 = 255;

/// Blackens pixels that draw less than `below`: 90 in 255 of them for `below` = 90.
pub fn pepper(image: &mut Plane<u8>, below: u8, seed: u64) {
    let black = first_draw(below.into());
    draw(image, "pepper", seed, |pixel, draw| if draw < black { 0 } else { pixel });
}

/// Blackens pixels that draw less than `low`, and makes those white that draw more than `high`.
pub fn salt_and_pepper(image: &mut Plane<u8>, low: u8, high: u8, seed: u64) {
    let (black, white) = (first_draw(low.into()), first_draw(u64::from(high) + 1));
    draw(image, "salt and pepper", seed, |pixel, draw| {
        // White is drawn last: it wins where `low` is above `high`.
        let pixel = if draw < black { 0 } else { pixel };
        if draw >= white { 255 } else { pixel }
    });
}

/// The lowest number of 32 bits that stands for `level` or more, as `number · 255 / 2³²`.
fn first_draw(level: u64) -> u64 {
    (level << 32).div_ceil(LEVELS)
}

fn draw(image: &mut Plane<u8>, purpose: &str, seed: u64, change: impl Fn(u8, u64) -> u8) {
    let noise = StageNoise::new(seed, purpose, 0);
    wide(
        #[inline(always)]
        || {
            let (pairs, last) = image.data_mut().as_chunks_mut::<2>();
            // Half of the bits for each of two pixels.
            let halves = |index| {
                let bits = noise.bits(index, 0);
                [bits & 0xffff_ffff, bits >> 32]
            };
            let count = pairs.len();
            for (index, pair) in pairs.iter_mut().enumerate() {
                let [first, second] = halves(index);
                *pair = [change(pair[0], first), change(pair[1], second)];
            }
            for pixel in last {
                *pixel = change(*pixel, halves(count)[0]);
            }
        },
    );
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
