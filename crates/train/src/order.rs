//! The order in which samples are drawn: shuffled without replacement, and without any state.
//!
//! Sample number `i` of a run is a pure function of (seed, `i`), so a resumed run continues with
//! exactly the samples the interrupted one would have seen.

use evpose_core::seed_for;

/// Rounds of the Feistel network; four make a permutation that passes for random.
const ROUNDS: u64 = 4;

/// A different pseudo-random permutation of `0..len` for each pass over the data.
///
/// # Source
/// A balanced Feistel network with cycle walking (Black and Rogaway, *Ciphers with arbitrary finite
/// domains*, CT-RSA 2002).
#[derive(Debug, Clone, Copy)]
pub struct SampleOrder {
    len: u64,
    half_bits: u32,
    seed: u64,
}

impl SampleOrder {
    /// An order over `len` samples.
    ///
    /// # Panics
    /// If `len` is zero.
    pub fn new(len: u64, seed: u64) -> Self {
        assert!(len > 0, "an order needs at least one sample");
        let bits = u64::BITS - (len - 1).leading_zeros();
        Self { len, half_bits: bits.div_ceil(2).max(1), seed }
    }

    /// The sample at position `position` of the endless sequence of passes.
    pub fn at(&self, position: u64) -> u64 {
        let (pass, mut index) = (position / self.len, position % self.len);
        // Cycle walking: the network permutes a power of four, so step until back inside.
        loop {
            index = self.permute(pass, index);
            if index < self.len {
                return index;
            }
        }
    }

    fn permute(&self, pass: u64, index: u64) -> u64 {
        let mask = (1 << self.half_bits) - 1;
        let (mut left, mut right) = (index >> self.half_bits, index & mask);
        // Each round can be undone, whatever it mixes in: no two indices meet.
        for round in 0..ROUNDS {
            let mixed = seed_for(self.seed, "sample order", (pass * ROUNDS + round) << 32 | right);
            (left, right) = (right, left ^ (mixed & mask));
        }
        left << self.half_bits | right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pass_visits_every_sample_once() {
        for len in [1, 2, 3, 64, 1000] {
            let order = SampleOrder::new(len, 5);
            for pass in 0..3 {
                let mut seen: Vec<u64> = (0..len).map(|i| order.at(pass * len + i)).collect();
                seen.sort_unstable();
                assert_eq!(seen, (0..len).collect::<Vec<_>>(), "{len} samples, pass {pass}");
            }
        }
    }

    #[test]
    fn passes_and_seeds_differ() {
        let pass = |seed, pass: u64| -> Vec<u64> {
            let order = SampleOrder::new(1000, seed);
            (0..1000).map(|i| order.at(pass * 1000 + i)).collect()
        };
        let fixed_points = |a: &[u64], b: &[u64]| a.iter().zip(b).filter(|(a, b)| a == b).count();
        assert!(fixed_points(&pass(1, 0), &pass(1, 1)) < 10);
        assert!(fixed_points(&pass(1, 0), &pass(2, 0)) < 10);
        assert!(fixed_points(&pass(1, 0), &(0..1000).collect::<Vec<_>>()) < 10);
    }
}
