//! Counter-based random numbers: a draw is a hash of its purpose and index, without state.
//!
//! Results are then the same for any block size and thread count, and adding a stage to a chain
//! does not move the noise of the others: `with effect - without effect` is free of noise.
//!
//! # Source
//! The mixing function is the finaliser of SplitMix64 (Steele, Lea, Flood: *Fast splittable
//! pseudorandom number generators*, OOPSLA 2014), with the constants of Stafford's variant 13.

use std::f32::consts::TAU;

/// 2^64 over the golden ratio: the increment of SplitMix64.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Twenty-four bits of a hash as a number in (0, 1]: never zero, so that its logarithm is finite.
fn unit(bits: u64) -> f32 {
    ((bits >> 40) + 1) as f32 / (1u64 << 24) as f32
}

/// Box-Muller transform of two uniform draws.
fn gaussian(u1: f32, u2: f32) -> f32 {
    (-2.0 * u1.ln()).sqrt() * (TAU * u2).cos()
}

/// A seed derived from `seed` for the purpose called `name`, number `index`.
///
/// Different names or indices give unrelated seeds.
pub fn seed_for(seed: u64, name: &str, index: u64) -> u64 {
    // FNV-1a over the name, then mixed: names differ in any letter.
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for byte in name.bytes() {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    }
    mix(mix(hash ^ mix(seed.wrapping_add(GOLDEN))).wrapping_add(index.wrapping_mul(GOLDEN)))
}

/// The noise of one stage at one tick, addressed by pixel and draw.
#[derive(Debug, Clone, Copy)]
pub struct StageNoise {
    key: u64,
}

impl StageNoise {
    /// Noise of the stage called `stage` at tick number `tick`.
    pub fn new(seed: u64, stage: &str, tick: u64) -> Self {
        Self::at_tick(seed_for(seed, stage, 0), tick)
    }

    /// The same from a key made once by [`seed_for`]`(seed, stage, 0)`.
    pub fn at_tick(stage_key: u64, tick: u64) -> Self {
        Self { key: mix(stage_key ^ tick.wrapping_mul(GOLDEN)) }
    }

    /// 64 random bits for a pixel and a draw number.
    pub fn bits(self, pixel: usize, draw: u32) -> u64 {
        // Neighbouring pixels differ in a few bits: mixing twice makes their draws unrelated.
        mix(self.key ^ mix(((pixel as u64) << 32) | u64::from(draw)))
    }

    /// Uniform in (0, 1].
    pub fn uniform(self, pixel: usize, draw: u32) -> f32 {
        unit(self.bits(pixel, draw))
    }

    /// Standard normal.
    pub fn normal(self, pixel: usize, draw: u32) -> f32 {
        gaussian(self.uniform(pixel, 2 * draw), self.uniform(pixel, 2 * draw + 1))
    }
}

/// A short sequence of random numbers for one purpose: scenario draws, initial weights, shuffles.
///
/// Two generators of the same `(seed, name, index)` give the same sequence.
#[derive(Debug, Clone)]
pub struct CounterRng {
    key: u64,
    count: u64,
}

impl CounterRng {
    /// The generator for the purpose called `name`, number `index`.
    pub fn new(seed: u64, name: &str, index: u64) -> Self {
        Self { key: seed_for(seed, name, index), count: 0 }
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.count += 1;
        mix(self.key ^ mix(self.count.wrapping_mul(GOLDEN)))
    }

    /// Uniform in (0, 1], 24 bits.
    pub fn unit(&mut self) -> f32 {
        unit(self.bits())
    }

    /// Uniform between `low` and `high`.
    pub fn uniform(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Standard normal.
    pub fn normal(&mut self) -> f32 {
        let (a, b) = (self.unit(), self.unit());
        gaussian(a, b)
    }

    /// An integer in `0..n`.
    ///
    /// # Panics
    /// If `n` is zero.
    pub fn below(&mut self, n: usize) -> usize {
        assert!(n > 0, "no integer lies below zero");
        // Multiply-shift: the bias is below n / 2^64.
        ((u128::from(self.bits()) * n as u128) >> 64) as usize
    }

    /// True with probability `p`.
    pub fn chance(&mut self, p: f32) -> bool {
        self.unit() <= p
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean_and_variance(draw: impl Fn(usize) -> f32) -> (f64, f64) {
        let n = 200_000;
        let mean = (0..n).map(|i| f64::from(draw(i))).sum::<f64>() / n as f64;
        let variance = (0..n).map(|i| (f64::from(draw(i)) - mean).powi(2)).sum::<f64>() / n as f64;
        (mean, variance)
    }

    #[test]
    fn uniform_draws_have_mean_and_variance_of_a_uniform() {
        let noise = StageNoise::new(7, "x", 3);
        let (mean, variance) = mean_and_variance(|i| noise.uniform(i, 0));
        // Four standard errors of 200,000 draws.
        assert!((mean - 0.5).abs() < 4.0 * (1.0 / 12.0 / 200_000f64).sqrt(), "{mean}");
        assert!((variance - 1.0 / 12.0).abs() < 0.001, "{variance}");
    }

    #[test]
    fn normal_draws_have_mean_and_variance_of_a_normal() {
        let noise = StageNoise::new(7, "x", 3);
        let (mean, variance) = mean_and_variance(|i| noise.normal(i, 0));
        assert!(mean.abs() < 4.0 / 200_000f64.sqrt(), "{mean}");
        assert!((variance - 1.0).abs() < 4.0 * (2.0 / 200_000f64).sqrt(), "{variance}");
    }

    #[test]
    fn neighbouring_pixels_ticks_and_stages_are_uncorrelated() {
        let n = 100_000;
        let here = StageNoise::new(1, "leak", 5);
        let correlation = |other: &dyn Fn(usize) -> f32| {
            (0..n)
                .map(|i| (f64::from(here.uniform(i, 0)) - 0.5) * (f64::from(other(i)) - 0.5))
                .sum::<f64>()
                // A uniform value has a variance of 1/12.
                / (n as f64 / 12.0)
        };
        let next_tick = StageNoise::new(1, "leak", 6);
        let other_stage = StageNoise::new(1, "shot", 5);
        for (name, r) in [
            ("pixel", correlation(&|i| here.uniform(i + 1, 0))),
            ("draw", correlation(&|i| here.uniform(i, 1))),
            ("tick", correlation(&|i| next_tick.uniform(i, 0))),
            ("stage", correlation(&|i| other_stage.uniform(i, 0))),
        ] {
            // This is four standard errors of a correlation of n pairs.
            assert!(r.abs() < 4.0 / (n as f64).sqrt(), "{name}: {r}");
        }
    }

    /// The generator's own test vector, of seed 1234567: `state += GOLDEN; mix(state)`.
    #[test]
    fn the_mixing_function_is_that_of_splitmix64() {
        let outputs = [
            6_457_827_717_110_365_317,
            3_203_168_211_198_807_973,
            9_817_491_932_198_370_423,
            4_593_380_528_125_082_431,
            16_408_922_859_458_223_821,
        ];
        for (count, output) in (1..).zip(outputs) {
            assert_eq!(mix(GOLDEN.wrapping_mul(count).wrapping_add(1_234_567)), output);
        }
    }

    /// With the published FNV-1a digests of names.
    #[test]
    fn seeds_and_bits_are_the_hashes_that_the_documentation_says() {
        for (name, fnv) in [("", 0xcbf2_9ce4_8422_2325), ("foobar", 0x8594_4171_f739_67e8)] {
            for (seed, index) in [(0, 0), (7, 1), (u64::MAX, 5)] {
                let named = mix(fnv ^ mix(GOLDEN.wrapping_add(seed)));
                let key = mix(GOLDEN.wrapping_mul(index).wrapping_add(named));
                assert_eq!(seed_for(seed, name, index), key);
                let mut rng = CounterRng::new(seed, name, index);
                for count in 1..4 {
                    assert_eq!(rng.bits(), mix(key ^ mix(GOLDEN.wrapping_mul(count))));
                }
                let stage = seed_for(seed, name, 0);
                let noise = StageNoise::new(seed, name, index);
                let tick = mix(stage ^ GOLDEN.wrapping_mul(index));
                assert_eq!(noise.bits(3, 9), mix(tick ^ mix((3 << 32) + 9)));
                // Two uniform draws make a normal one, and no two normal ones share any.
                let pair = (noise.uniform(3, 18), noise.uniform(3, 19));
                assert_eq!(noise.normal(3, 9), gaussian(pair.0, pair.1));
            }
        }
    }

    #[test]
    fn sequences_are_uniform_between_their_ends_normal_or_as_likely_as_asked() {
        let n = 200_000;
        let near = |(mean, variance): (f64, f64), wanted: f64, squared: f64| {
            let error = 4.0 * (squared / f64::from(n)).sqrt();
            assert!((mean - wanted).abs() < error, "{mean} {wanted}");
            assert!((variance / squared - 1.0).abs() < 0.02, "{variance} {squared}");
        };
        let of = |draw: &dyn Fn(&mut CounterRng) -> f32| {
            let rng = std::cell::RefCell::new(CounterRng::new(5, "draws", 0));
            mean_and_variance(|_| draw(&mut rng.borrow_mut()))
        };
        for (low, high) in [(2.0, 5.0), (-3.0, -1.0)] {
            let (middle, width) = (0.5 * f64::from(low + high), f64::from(high - low));
            near(of(&|rng| rng.uniform(low, high)), middle, width * width / 12.0);
            let mut rng = CounterRng::new(5, "range", 0);
            assert!((0..1_000).map(|_| rng.uniform(low, high)).all(|x| low < x && x <= high));
        }
        near(of(&CounterRng::normal), 0.0, 1.0);
        for p in [0.1, 0.75] {
            let share = f64::from(p);
            near(of(&|rng| f32::from(u8::from(rng.chance(p)))), share, share * (1.0 - share));
        }
    }

    #[test]
    fn unit_draws_are_above_zero_and_one_at_most() {
        assert_eq!((unit(0), unit(u64::MAX)), (1.0 / 16_777_216.0, 1.0));
        // Half of the bits below the 24 that count.
        assert_eq!(unit(1 << 39), unit(0));
        assert_eq!(unit(1 << 63), 0.5 + unit(0));
    }

    #[test]
    fn integers_below_n_are_all_reached() {
        let mut rng = CounterRng::new(3, "below", 0);
        let mut seen = [0usize; 5];
        for _ in 0..5_000 {
            seen[rng.below(5)] += 1;
        }
        // 1,000 are expected, with a standard deviation of 28.
        assert!(seen.iter().all(|&c| (850..1150).contains(&c)), "{seen:?}");
    }
}
