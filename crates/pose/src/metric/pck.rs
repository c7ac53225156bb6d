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

/// Counts of errors by the first threshold they lie below. Counts add up over sequences.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pck {
    /// Errors whose first threshold above them is number `i`.
    counts: Vec<u64>,
    /// All errors, those beyond every threshold included.
    total: u64,
}

impl Pck {
    /// No error yet.
    pub fn new() -> Self {
        Self { counts: vec![0; THRESHOLDS], total: 0 }
    }

    /// Threshold number `i`.
    pub fn threshold(i: usize) -> f64 {
        i as f64 * 0.1
    }

    /// Adds an error, in the unit of the thresholds. One that is not a number lies below none.
    pub fn push(&mut self, error: f64) {
        self.total += 1;
        // A first guess, at most one off by rounding; the comparison itself decides.
        let guess = (error * 10.0).clamp(0.0, THRESHOLDS as f64) as usize;
        let first = (guess.saturating_sub(1)..THRESHOLDS).find(|&i| error < Self::threshold(i));
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

    /// `PCK` at every threshold, or none where nothing was measured.
    pub fn curve(&self) -> Vec<f64> {
        if self.is_empty() {
            return Vec::new();
        }
        let correct = self.counts.iter().scan(0, |sum, &count| {
            *sum += count;
            Some(*sum)
        });
        correct.map(|correct| correct as f64 / self.total as f64).collect()
    }

    /// The area under the curve, between 0 and 0.999.
    pub fn auc(&self) -> Option<f64> {
        self.totals().mean()
    }

    /// Sum of all errors' contributions to the area, and their count.
    pub fn totals(&self) -> Totals {
        let above = self.counts.iter().enumerate().map(|(i, &n)| n * (THRESHOLDS - i) as u64);
        Totals { sum: above.sum::<u64>() as f64 / THRESHOLDS as f64, count: self.total }
    }
}

impl Default for Pck {
    fn default() -> Self {
        Self::new()
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
        assert!((pck.auc().expect("measured") - 0.4995).abs() < 1e-9);
        for (i, share) in pck.curve().into_iter().enumerate() {
            assert!((share - Pck::threshold(i) / 100.0).abs() < 1e-9, "{i}: {share}");
        }
    }

    #[test]
    fn a_perfect_prediction_scores_one_less_the_first_threshold() {
        assert_eq!(pck_from_errors([0.0; 3]).auc(), Some(0.999));
    }

    #[test]
    fn the_comparison_is_strict() {
        // 25.5 is a threshold: 25.6 is the first above, which leaves 744 of 1000.
        assert_eq!(pck_from_errors([25.5]).auc(), Some(0.744));
        assert_eq!(pck_from_errors([25.499]).auc(), Some(0.745));
    }

    #[test]
    fn what_is_far_or_not_a_number_counts_as_wrong() {
        assert_eq!(pck_from_errors([99.95, 1e9, f64::INFINITY, f64::NAN]).auc(), Some(0.0));
        assert_eq!(Pck::new().auc(), None);
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
        fn a_larger_error_never_raises_the_area(a in 0.0..150.0, b in 0.0..150.0) {
            let (small, large) = (f64::min(a, b), f64::max(a, b));
            prop_assert!(pck_from_errors([small]).auc() >= pck_from_errors([large]).auc());
        }

        #[test]
        fn merged_sequences_are_one(a in errors(0..20), b in errors(0..20)) {
            let mut merged = pck_from_errors(a.clone());
            merged.merge(&pck_from_errors(b.clone()));
            prop_assert_eq!(merged, pck_from_errors(a.into_iter().chain(b)));
        }
    }
}
