//! The share of correct keypoints, and the area under its curve.
//!
//! # Model
//! `PCK(x)` is the fraction of errors strictly below `x`. It is taken at the thresholds 0, 0.1, …,
//! 99.9, in percent of the palm or in millimetres, and `AUC = Σ PCK(x)·0.1/100`. As no error lies
//! below 0, even a perfect prediction scores only 0.999.
//!
//! The AUC is the mean over errors of what each contributes, so it pools and resamples as a mean.
//!
//! # Source
//! EventHands' evaluation program.

use evpose_core::stats::bootstrap::Totals;

/// How many thresholds the curve has, 0.1 apart from 0 on.
pub const THRESHOLDS: usize = 1_000;

/// Errors of hands at these thresholds.
pub type Pck = ErrorCounts<THRESHOLDS>;

/// Counts of errors by the first of `N` thresholds at which they are correct. Counts add up over
/// sequences.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ErrorCounts<const N: usize> {
    counts: Vec<u64>,
    /// All errors, those beyond every threshold included.
    total: u64,
}

impl<const N: usize> ErrorCounts<N> {
    /// No error yet.
    pub fn new() -> Self {
        Self { counts: vec![0; N], total: 0 }
    }

    /// Adds an error whose first threshold is number `first`; none of one that is wrong at all.
    pub(crate) fn count(&mut self, first: Option<usize>) {
        self.total += 1;
        if let Some(count) = first.and_then(|i| self.counts.get_mut(i)) {
            *count += 1;
        }
    }

    /// Adds the errors of another sequence.
    pub fn merge(&mut self, other: &Self) {
        for (count, more) in self.counts.iter_mut().zip(&other.counts) {
            *count += more;
        }
        self.total += other.total;
    }

    /// How many errors there are.
    pub fn len(&self) -> u64 {
        self.total
    }

    /// Whether nothing was measured.
    pub fn is_empty(&self) -> bool {
        self.total == 0
    }

    /// How many are correct at the first `thresholds` thresholds, and how many there are.
    pub fn correct(&self, thresholds: usize) -> Totals {
        let correct: u64 = self.counts.iter().take(thresholds).sum();
        Totals { sum: correct as f64, count: self.total }
    }

    /// The fraction of correct ones at every threshold; empty where nothing was measured.
    pub fn curve(&self) -> Vec<f64> {
        let mut correct = 0;
        let share = |count: &u64| {
            correct += count;
            Totals { sum: correct as f64, count: self.total }.mean()
        };
        self.counts.iter().filter_map(share).collect()
    }

    /// Sum of all errors' contributions to the area, and their count: the area is the mean.
    pub fn area(&self) -> Totals {
        // An error is correct at its first threshold and at all above it.
        let above = self.counts.iter().enumerate().map(|(i, &n)| n * (N - i) as u64);
        Totals { sum: above.sum::<u64>() as f64 / N as f64, count: self.total }
    }
}

impl<const N: usize> Default for ErrorCounts<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl Pck {
    /// Threshold number `i`.
    pub fn threshold(i: usize) -> f64 {
        i as f64 * 0.1
    }

    /// Adds an error, in the unit of the thresholds. One that is not a number lies below none.
    pub fn push(&mut self, error: f64) {
        // A first guess, at most one off by rounding; the comparison itself decides.
        let guess = (error * 10.0).clamp(0.0, THRESHOLDS as f64) as usize;
        self.count((guess.saturating_sub(1)..THRESHOLDS).find(|&i| error < Self::threshold(i)));
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn pck_from_errors(errors: impl IntoIterator<Item = f64>) -> Pck {
        let mut pck = Pck::new();
        errors.into_iter().for_each(|error| pck.push(error));
        pck
    }

    /// Errors of which half lie exactly on a threshold.
    fn errors(len: std::ops::Range<usize>) -> impl Strategy<Value = Vec<f64>> {
        let error = prop_oneof![0.0..120.0, (0usize..1_200).prop_map(Pck::threshold)];
        prop::collection::vec(error, len)
    }

    #[test]
    fn uniform_errors_have_the_area_of_a_triangle() {
        let pck = pck_from_errors((0..100_000).map(|i| (f64::from(i) + 0.5) * 1e-3));
        // Σ i·0.1/100 · 0.1/100 over i in 0..1000.
        assert!((pck.area().mean().expect("measured") - 0.4995).abs() < 1e-9);
        for (i, share) in pck.curve().into_iter().enumerate() {
            assert!((share - Pck::threshold(i) / 100.0).abs() < 1e-9, "{i}: {share}");
        }
    }

    #[test]
    fn the_comparison_is_strict() {
        assert_eq!(pck_from_errors([0.0; 3]).area().mean(), Some(0.999));
        // 25.5 is a threshold: 25.6 is the first above, which leaves 744 of 1000.
        assert_eq!(pck_from_errors([25.5]).area().mean(), Some(0.744));
        assert_eq!(pck_from_errors([25.499]).area().mean(), Some(0.745));
    }

    #[test]
    fn what_is_far_or_not_a_number_counts_as_wrong() {
        assert_eq!(pck_from_errors([99.95, 1e9, f64::INFINITY, f64::NAN]).area().mean(), Some(0.0));
        assert_eq!(Pck::new().area().mean(), None);
    }

    proptest! {
        #[test]
        fn the_curve_is_the_count_at_every_threshold(errors in errors(1..40)) {
            let curve = pck_from_errors(errors.iter().copied()).curve();
            for (i, share) in curve.into_iter().enumerate() {
                let below = errors.iter().filter(|&&e| e < Pck::threshold(i)).count();
                prop_assert_eq!(share, below as f64 / errors.len() as f64);
            }
        }

        #[test]
        fn merged_sequences_are_one(a in errors(0..20), b in errors(0..20)) {
            let mut merged = pck_from_errors(a.clone());
            merged.merge(&pck_from_errors(b.clone()));
            prop_assert_eq!(merged, pck_from_errors(a.into_iter().chain(b)));
        }
    }
}
