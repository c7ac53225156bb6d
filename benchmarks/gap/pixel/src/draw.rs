//! Random draws addressed by (seed, purpose, pixel, index).
//!
//! Nothing is drawn in sequence across pixels or purposes: a draw is a hash of its address
//! (finaliser of SplitMix64, Steele et al. 2014). Switching one effect on can therefore not
//! reshuffle the draws of another, and the number of threads cannot matter.

/// Purpose of a draw: one value for each independent set of draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Purpose {
    /// Shapes and motions of a scene.
    Scene = 1,
    /// Comparator offset of the ON side, one for each pixel.
    OffsetOn,
    /// Comparator offset of the OFF side.
    OffsetOff,
    /// Comparator noise of the ON side, one for each event.
    ComparatorOn,
    /// Comparator noise of the OFF side.
    ComparatorOff,
    /// Spread of the junction's leakage over the pixels.
    Leakage,
    /// Photoreceptor noise, by clock tick.
    Photoreceptor,
    /// Times, acceptance and polarity of photon-noise events.
    Photon,
    /// Background events ON.
    BackgroundOn,
    /// Background events OFF.
    BackgroundOff,
    /// Positions and rates of hot pixels.
    HotMap,
    /// Times and polarities of the events of hot pixels.
    HotEvents,
    /// Jitter of the time-stamper, by event.
    Jitter,
    /// Selection of events that are delayed, lost or copied.
    Oddity,
    /// Choices of the plan.
    Plan,
    /// Spread of the latency over the pixels.
    Latency,
    /// Choices of the conventions of a camera.
    Convention,
}

/// SplitMix64's finaliser: a bijection of 64-bit words in which every bit matters.
pub fn mix(word: u64) -> u64 {
    let mut z = word.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The draws of one seed, purpose and pixel, addressed by index.
#[derive(Debug, Clone, Copy)]
pub struct Stream {
    key: u64,
}

impl Stream {
    /// The stream of `seed`, `purpose` and `pixel` (or any other number in its place).
    pub fn new(seed: u64, purpose: Purpose, pixel: u64) -> Self {
        Self { key: mix(mix(mix(seed) ^ purpose as u64).wrapping_add(pixel)) }
    }

    /// 64 random bits.
    pub fn bits(self, index: u64) -> u64 {
        mix(self.key ^ index.wrapping_mul(0xd134_2543_de82_ef95))
    }

    /// Uniform in the open interval (0, 1).
    pub fn uniform(self, index: u64) -> f64 {
        ((self.bits(index) >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
    }

    /// Standard normal.
    pub fn normal(self, index: u64) -> f64 {
        normal_quantile(self.uniform(index))
    }

    /// Exponential with mean 1.
    pub fn exponential(self, index: u64) -> f64 {
        -self.uniform(index).ln()
    }
}

/// Draws one after the other from a stream, for things built once (scenes, the plan).
#[derive(Debug, Clone)]
pub struct Sequence {
    stream: Stream,
    next: u64,
}

impl Sequence {
    /// Starts at the first draw of the stream.
    pub fn new(seed: u64, purpose: Purpose, key: u64) -> Self {
        Self { stream: Stream::new(seed, purpose, key), next: 0 }
    }

    fn advance(&mut self) -> u64 {
        self.next += 1;
        self.next - 1
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        let index = self.advance();
        self.stream.bits(index)
    }

    /// Uniform between `low` and `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        let index = self.advance();
        low + (high - low) * self.stream.uniform(index)
    }

    /// Log-uniform between two positive values.
    pub fn log_between(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// An integer below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.bits() >> 11) % count.max(1) as u64) as usize
    }

    /// -1 or +1.
    pub fn sign(&mut self) -> f64 {
        if self.bits() >> 63 == 0 { -1.0 } else { 1.0 }
    }

    /// Shuffles in place (Fisher & Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }
}

/// Quantile of the standard normal: Acklam's rational approximation, relative error below 1.2e-9.
fn normal_quantile(p: f64) -> f64 {
    const A: [f64; 6] = [
        -3.969_683_028_665_376e1,
        2.209_460_984_245_205e2,
        -2.759_285_104_469_687e2,
        1.383_577_518_672_69e2,
        -3.066_479_806_614_716e1,
        2.506_628_277_459_239,
    ];
    const B: [f64; 5] = [
        -5.447_609_879_822_406e1,
        1.615_858_368_580_409e2,
        -1.556_989_798_598_866e2,
        6.680_131_188_771_972e1,
        -1.328_068_155_288_572e1,
    ];
    const C: [f64; 6] = [
        -7.784_894_002_430_293e-3,
        -3.223_964_580_411_365e-1,
        -2.400_758_277_161_838,
        -2.549_732_539_343_734,
        4.374_664_141_464_968,
        2.938_163_982_698_783,
    ];
    const D: [f64; 4] = [
        7.784_695_709_041_462e-3,
        3.224_671_290_700_398e-1,
        2.445_134_137_142_996,
        3.754_408_661_907_416,
    ];
    // Acklam's approximation has polynomials of its own beyond these probabilities.
    const TAIL: f64 = 0.024_25;
    let horner = |c: &[f64], x: f64| c.iter().fold(0.0, |sum, k| sum * x + k);
    if (TAIL..=1.0 - TAIL).contains(&p) {
        let q = p - 0.5;
        let r = q * q;
        horner(&A, r) * q / (horner(&B, r) * r + 1.0)
    } else {
        // The tails differ in their sign alone.
        let q = (-2.0 * p.min(1.0 - p).ln()).sqrt();
        let tail = horner(&C, q) / (horner(&D, q) * q + 1.0);
        if p < 0.5 { tail } else { -tail }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_normal_quantile_has_the_tabulated_values() {
        for (p, z) in [(0.5, 0.0), (0.975, 1.959_963_985), (0.001, -3.090_232_306)] {
            assert!((normal_quantile(p) - z).abs() < 1e-7, "{p}");
        }
    }

    #[test]
    fn uniform_draws_have_the_moments_of_a_uniform() {
        let stream = Stream::new(5, Purpose::Plan, 3);
        let n = 100_000;
        let (mut sum, mut square) = (0.0, 0.0);
        for i in 0..n {
            let u = stream.uniform(i);
            sum += u;
            square += u * u;
        }
        let mean = sum / n as f64;
        // Four standard errors of each.
        assert!((mean - 0.5).abs() < 4.0 * (1.0 / 12.0 / n as f64).sqrt());
        assert!((square / n as f64 - 1.0 / 3.0).abs() < 4.0 * (4.0 / 45.0 / n as f64).sqrt());
    }

    #[test]
    fn another_purpose_or_pixel_gives_other_draws() {
        let bits = |purpose, pixel| Stream::new(1, purpose, pixel).bits(0);
        assert_ne!(bits(Purpose::OffsetOn, 0), bits(Purpose::OffsetOff, 0));
        assert_ne!(bits(Purpose::OffsetOn, 0), bits(Purpose::OffsetOn, 1));
        assert_eq!(bits(Purpose::OffsetOn, 7), bits(Purpose::OffsetOn, 7));
    }
}
