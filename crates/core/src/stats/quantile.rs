//! Quantiles of samples and of histograms.
//!
//! Samples of `n` values have several quantiles of a probability `q`; Hyndman and Fan, *Sample
//! quantiles in statistical packages*, The American Statistician 50, 1996, list the rules. Those
//! used here:
//!
//! | function | rule | value, 0-based |
//! |---|---|---|
//! | [`nearest_rank`] | type 1, the inverse of the empirical distribution function | `sorted[⌈q n⌉ - 1]` |
//! | [`upper_index`] | its right-continuous inverse | `sorted[⌊q n⌋]` |
//! | [`nearest_index`] | the order statistic next to the linear one (NumPy: `nearest`) | `sorted[round(q (n - 1))]` |
//! | [`linear`] | type 7, linear interpolation (the default of R and NumPy) | at `q (n - 1)` |
//!
//! Functions ending in `_index` return the place of the order statistic, for a sorted slice or for
//! `select_nth_unstable`.

/// Scale that makes the median absolute deviation of a normal sample its standard deviation,
/// inverted.
const NORMAL_MAD: f64 = 0.6745;

/// Modified z-scores above this are outliers: Iglewicz and Hoaglin, *How to detect and handle
/// outliers*, 1993.
const OUTLIER_Z: f64 = 3.5;

/// Smallest median absolute deviation, so that samples of equal values have no outliers by
/// rounding.
const MIN_MAD: f64 = 1e-9;

/// The nearest-rank quantile of a sorted sample: the smallest value with at least a share `q` of
/// the sample at or below it.
///
/// # Panics
/// On an empty sample.
///
/// ```
/// use evpose_core::stats::quantile::nearest_rank;
///
/// let sorted = [1.0, 2.0, 3.0, 4.0];
/// assert_eq!([0.25, 0.5, 0.51, 1.0].map(|q| nearest_rank(&sorted, q)), [1.0, 2.0, 3.0, 4.0]);
/// ```
pub fn nearest_rank(sorted: &[f64], q: f64) -> f64 {
    let rank = (q * sorted.len() as f64).ceil() as usize;
    sorted[rank.clamp(1, sorted.len()) - 1]
}

/// The type-7 quantile of a sorted sample: linear interpolation between order statistics.
///
/// # Panics
/// On an empty sample.
pub fn linear(sorted: &[f64], q: f64) -> f64 {
    let position = q * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[position.floor() as usize], sorted[position.ceil() as usize]);
    below + (above - below) * position.fract()
}

/// Index of the order statistic nearest to the type-7 quantile; 0 for an empty sample.
pub fn nearest_index(len: usize, q: f64) -> usize {
    (len.saturating_sub(1) as f64 * q).round() as usize
}

/// Index of the smallest value with more than `numerator / denominator` of the sample at or below
/// it.
///
/// `upper_index(len, 1, 2)` is the median, the higher of two middle values. The index of a share of one
/// is `len`, beyond the sample, as for an empty one.
pub const fn upper_index(len: usize, numerator: usize, denominator: usize) -> usize {
    len * numerator / denominator
}

/// The median of values in any order: the mean of the two in the middle of an even number; none of
/// an empty sample. Sorts the values.
///
/// ```
/// use evpose_core::stats::quantile::median;
///
/// assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), Some(2.5));
/// assert_eq!(median(&mut []), None);
/// ```
pub fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    // In an odd sample both indices are those of the one in the middle.
    Some(f64::midpoint(values[last / 2], values[values.len() / 2]))
}

/// The higher median of values in any order ([`upper_index`]); none of an empty sample. Reorders
/// the values.
pub fn median_high(values: &mut [f64]) -> Option<f64> {
    let middle = upper_index(values.len(), 1, 2);
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Values of a sorted sample whose modified z-score, `0.6745 |x - median| / MAD`, exceeds 3.5.
///
/// # Panics
/// On an empty sample.
pub fn outlier_count(sorted: &[f64]) -> usize {
    let median = nearest_rank(sorted, 0.5);
    let mut deviations: Vec<f64> = sorted.iter().map(|value| (value - median).abs()).collect();
    deviations.sort_by(f64::total_cmp);
    let mad = nearest_rank(&deviations, 0.5).max(MIN_MAD);
    sorted.iter().filter(|value| NORMAL_MAD * (*value - median).abs() / mad > OUTLIER_Z).count()
}

/// The quantile of a histogram: its bin, and how far into the bin it lies, from 0 to 1, counts
/// being spread evenly over their bin. None where all counts are zero.
pub fn of_histogram(
    counts: impl IntoIterator<Item = u64, IntoIter: Clone>,
    q: f64,
) -> Option<(usize, f64)> {
    let counts = counts.into_iter();
    let rank = q * counts.clone().sum::<u64>() as f64;
    let mut below = 0.0;
    // An empty bin holds no quantile.
    for (bin, count) in counts.enumerate().filter(|(_, count)| *count > 0) {
        let count = count as f64;
        if below + count >= rank {
            return Some((bin, (rank - below) / count));
        }
        below += count;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_ranks_are_values_of_the_sample() {
        let values: Vec<f64> = (1..=100).map(f64::from).collect();
        let quantiles = [0.5, 0.95, 0.99, 1.0].map(|q| nearest_rank(&values, q));
        assert_eq!(quantiles, [50.0, 95.0, 99.0, 100.0]);
        assert_eq!(nearest_rank(&[7.0], 0.99), 7.0);
    }

    #[test]
    fn linear_quantiles_interpolate_between_neighbours() {
        let sorted = [0.0, 1.0, 2.0, 4.0];
        assert_eq!([0.0, 0.5, 1.0].map(|q| linear(&sorted, q)), [0.0, 1.5, 4.0]);
        // R: quantile(c(0, 1, 2, 4), 0.9) is 3.4.
        assert!((linear(&sorted, 0.9) - 3.4).abs() < 1e-12);
    }

    #[test]
    fn indices_are_those_of_their_rules() {
        assert_eq!([0.0, 0.25, 0.5, 1.0].map(|q| nearest_index(42, q)), [0, 10, 21, 41]);
        assert_eq!(nearest_index(0, 0.5), 0);
        assert_eq!([1, 2, 3].map(|i| upper_index(10, i, 4)), [2, 5, 7]);
        // The smallest value with more than the share at or below it.
        for (len, share) in (1..20).flat_map(|len| (0..7).map(move |share| (len, share))) {
            let index = (0..len).find(|i| 7 * (i + 1) > share * len);
            assert_eq!(Some(upper_index(len, share, 7)), index, "{share} sevenths of {len}");
        }
    }

    #[test]
    fn medians_of_even_samples_differ_by_their_rule() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median_high(&mut [4.0, 1.0, 2.0, 3.0]), Some(3.0));
        assert_eq!((median(&mut []), median_high(&mut [])), (None, None));
    }

    /// 1 to 9: median 5, median deviation 2, so that outliers are beyond 3.5 / 0.6745 * 2 = 10.38.
    #[test]
    fn outliers_are_beyond_three_and_a_half_modified_scores_on_either_side() {
        let with = |far: f64| {
            let mut values: Vec<f64> = (1..=9).map(f64::from).collect();
            values[if far > 5.0 { 8 } else { 0 }] = far;
            values.sort_by(f64::total_cmp);
            outlier_count(&values)
        };
        assert_eq!([15.37, 15.38, -5.37, -5.38].map(with), [0, 1, 0, 1]);
        assert_eq!(outlier_count(&[7.0; 5]), 0);
        assert_eq!(outlier_count(&[7.0, 7.0, 7.0, 7.0, 7.1]), 1, "a half of equal values");
    }

    #[test]
    fn a_slow_run_is_an_outlier() {
        let mut values: Vec<f64> = (0..50).map(|i| 10.0 + 0.01 * f64::from(i)).collect();
        assert_eq!(outlier_count(&values), 0);
        values.push(30.0);
        assert_eq!(outlier_count(&values), 1);
    }

    #[test]
    fn counts_spread_evenly_over_their_bin() {
        let counts = [0, 0, 0, 50, 0, 0, 0, 50];
        assert_eq!(
            [0.25, 0.5, 0.75].map(|q| of_histogram(counts, q)),
            [Some((3, 0.5)), Some((3, 1.0)), Some((7, 0.5))]
        );
        assert_eq!(of_histogram([0; 4], 0.5), None);
    }
}
