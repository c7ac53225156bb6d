//! Shares with intervals, reliability of probabilities, uniformity, medians.

use evpose_core::stats::distribution::kolmogorov_upper_tail;
use evpose_core::stats::interval::{median_bound_indices, wilson};
use evpose_core::stats::quantile;
use serde::Serialize;

/// Edges of the bins of stated probabilities; most are near one.
const EDGES: [f64; 11] = [0.0, 0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 1.0];

/// How many of how many, with the Wilson interval of 95 %.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(super) struct Rate {
    pub(super) of: usize,
    pub(super) n: usize,
    pub(super) share: Option<f64>,
    pub(super) lo95: f64,
    pub(super) hi95: f64,
}

impl Rate {
    pub(super) fn from_outcomes(is: impl IntoIterator<Item = bool>) -> Self {
        let (mut of, mut n) = (0, 0);
        for is in is {
            of += usize::from(is);
            n += 1;
        }
        let (lo95, hi95) = wilson(of, n);
        Self { of, n, share: (n > 0).then(|| of as f64 / n as f64), lo95, hi95 }
    }
}

/// Names whose stated probability lies between two edges.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Bin {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) stated: f64,
    pub(super) right: Rate,
}

/// Bins that hold anything, of stated probabilities and whether the name was right.
pub(super) fn bins(names: &[(f64, bool)]) -> Vec<Bin> {
    let bin = |edges: &[f64]| {
        let (from, to) = (edges[0], edges[1]);
        // The last bin holds its upper edge, or a probability of 1 would be in none.
        let is_in = |p: f64| p >= from && (p < to || (to == 1.0 && p <= 1.0));
        let inside: Vec<(f64, bool)> =
            names.iter().copied().filter(|(stated, _)| is_in(*stated)).collect();
        let stated = inside.iter().map(|(stated, _)| stated).sum::<f64>() / inside.len() as f64;
        let right = Rate::from_outcomes(inside.iter().map(|(_, is_right)| *is_right));
        (!inside.is_empty()).then_some(Bin { from, to, stated, right })
    };
    EDGES.windows(2).filter_map(bin).collect()
}

/// The expected calibration error: how far shares are from what was stated, weighed by names.
pub(super) fn calibration_error(bins: &[Bin]) -> Option<f64> {
    let n: usize = bins.iter().map(|bin| bin.right.n).sum();
    let off =
        |bin: &Bin| bin.right.share.map(|share| bin.right.n as f64 * (share - bin.stated).abs());
    let sum: f64 = bins.iter().filter_map(off).sum();
    (n > 0).then(|| sum / n as f64)
}

/// Probabilities stated of names, and how many of these are right.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(super) struct Stated {
    /// The mean of what was stated; none of no names.
    pub(super) mean: Option<f64>,
    pub(super) right: Rate,
}

impl Stated {
    pub(super) fn of(names: &[(f64, bool)]) -> Self {
        let sum: f64 = names.iter().map(|(stated, _)| stated).sum();
        let mean = (!names.is_empty()).then(|| sum / names.len() as f64);
        Self { mean, right: Rate::from_outcomes(names.iter().map(|(_, is_right)| *is_right)) }
    }

    /// Whether what was stated is inside the interval of what is right.
    pub(super) fn holds(&self) -> bool {
        self.mean.is_none_or(|mean| (self.right.lo95..=self.right.hi95).contains(&mean))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Uniformity {
    /// The largest difference of distribution functions.
    pub(super) largest: f64,
    /// The probability of such a difference where probabilities are uniform.
    pub(super) p: f64,
}

/// The test of Kolmogorov and Smirnov for probabilities that are multiples of one in `steps`, as
/// those from replicates are: their distribution function is looked at where they can be. That is
/// conservative.
///
/// # Source
/// Stephens, J. R. Stat. Soc. B 32, 1970, for the probability from finitely many.
pub(super) fn uniformity(ps: &[f64], steps: usize) -> Option<Uniformity> {
    if ps.is_empty() {
        return None;
    }
    let n = ps.len() as f64;
    let off = |k: usize| {
        let at = k as f64 / steps as f64;
        // A multiple that was computed in another way may lie just above itself.
        let below = ps.iter().filter(|p| **p <= at + 1e-9).count() as f64;
        (below / n - at).abs()
    };
    let largest = (1..=steps).map(off).fold(0.0, f64::max);
    let root = n.sqrt();
    Some(Uniformity { largest, p: kolmogorov_upper_tail((root + 0.12 + 0.11 / root) * largest) })
}

/// A median with the interval of 95 % that order statistics give.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Median {
    pub(super) value: f64,
    pub(super) lo95: f64,
    pub(super) hi95: f64,
    pub(super) n: usize,
}

/// The median of finite values; none of nothing.
pub(super) fn median(values: impl IntoIterator<Item = f64>) -> Option<Median> {
    let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
    let value = quantile::median(&mut values)?;
    // The values are sorted now.
    let [lo95, hi95] = median_bound_indices(values.len()).map(|index| values[index]);
    Some(Median { value, lo95, hi95, n: values.len() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_of_shares_are_those_of_wilson() {
        let none = Rate::from_outcomes([false; 5]);
        assert!(none.lo95 == 0.0 && (none.hi95 - 0.4345).abs() < 1e-4);
        assert_eq!(Rate::from_outcomes([]).share, None);
    }

    #[test]
    fn the_calibration_error_weighs_bins_by_their_names() {
        // Nine of ten right at .92 (off by .02), one of two at .55 (off by .05).
        let mut names: Vec<(f64, bool)> = (0..10).map(|i| (0.92, i > 0)).collect();
        names.extend([(0.55, true), (0.55, false)]);
        let bins = bins(&names);
        assert_eq!(bins.len(), 2);
        let expected = (10.0 * 0.02 + 2.0 * 0.05) / 12.0;
        assert!((calibration_error(&bins).unwrap() - expected).abs() < 1e-12);
        assert_eq!(calibration_error(&[]), None);
    }

    #[test]
    fn every_probability_is_in_one_bin() {
        let names: Vec<(f64, bool)> = (0..=100).map(|i| (f64::from(i) / 100.0, true)).collect();
        assert_eq!(bins(&names).iter().map(|bin| bin.right.n).sum::<usize>(), 101);
    }

    #[test]
    fn probabilities_that_are_all_small_are_not_uniform() {
        let uniform: Vec<f64> = (1..=200).map(|k| f64::from(k) / 200.0).collect();
        let measured = uniformity(&uniform, 200).unwrap();
        assert!(measured.largest < 1e-9 && measured.p > 0.999);
        let small: Vec<f64> = uniform.iter().map(|p| 0.5 * p).collect();
        let measured = uniformity(&small, 200).unwrap();
        assert!((measured.largest - 0.5).abs() < 0.01 && measured.p < 1e-6);
        assert_eq!(uniformity(&[], 200), None);
    }

    #[test]
    fn medians_lie_inside_their_intervals() {
        let measured = median((1..=100).map(f64::from)).unwrap();
        assert!((measured.value - 50.5).abs() < 1e-12);
        // Ranks 40 and 61, as in the tables.
        assert_eq!((measured.lo95, measured.hi95, measured.n), (40.0, 61.0, 100));
        assert_eq!(median([f64::NAN]), None);
    }
}
