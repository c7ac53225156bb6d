//! Heights of steps, counted in fine bins so that medians of any set of tiles are quick.

use evpose_core::stats::quantile;

/// Heights up to this are counted; a threshold is far below.
const HIGHEST: f32 = 2.0;
/// Bins of a histogram.
const BINS: usize = 4_000;

/// A histogram of heights of steps.
#[derive(Debug, Clone)]
pub(crate) struct Heights(Vec<u32>);

impl Heights {
    pub(crate) fn new() -> Self {
        Self(vec![0; BINS])
    }

    /// Counts a height, which is that of no step if it is not positive.
    pub(crate) fn add(&mut self, height: f32) {
        if height > 0.0 && height < HIGHEST {
            self.0[(height / HIGHEST * BINS as f32) as usize] += 1;
        }
    }
}

/// The median of all heights of some histograms, in a line inside its bin; not a number if there
/// are none.
pub(crate) fn median<'a>(of: impl Iterator<Item = &'a Heights>) -> f64 {
    // Histograms add up: a bootstrap over tiles need not go over the events again.
    let mut sums = vec![0_u64; BINS];
    for heights in of {
        for (sum, n) in sums.iter_mut().zip(&heights.0) {
            *sum += u64::from(*n);
        }
    }
    let (bin, inside) = quantile::of_histogram(sums, 0.5).unwrap_or((0, f64::NAN));
    f64::from(HIGHEST) * (bin as f64 + inside) / BINS as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_counted_from_above_zero_to_below_two() {
        for (height, counts) in [(0.0, 0), (1e-4, 1), (1.9999, 1), (2.0, 0), (-0.1, 0)] {
            let mut heights = Heights::new();
            heights.add(height);
            assert_eq!(heights.0.iter().sum::<u32>(), counts, "{height}");
        }
        // A single height is the middle of its bin of 5e-4.
        let mut heights = Heights::new();
        heights.add(0.7001);
        assert!((median([&heights].into_iter()) - 0.70025).abs() < 1e-9);
    }

    #[test]
    fn a_median_is_of_all_histograms_together() {
        let (mut a, mut b) = (Heights::new(), Heights::new());
        for height in [0.1, 0.2, 0.3] {
            a.add(height);
        }
        for height in [0.4, 0.5, -1.0, f32::NAN, 3.0] {
            b.add(height);
        }
        assert!((median([&a, &b].into_iter()) - 0.3).abs() < 6e-4);
        assert!(median(std::iter::empty()).is_nan());
    }
}
