//! Correction for multiple tests against surrogates.
//!
//! # Method
//! Westfall and Young 1993, single step: a statistic's corrected p-value is the fraction of
//! surrogates whose largest deviation over all statistics is at least its own. Deviations are
//! one-sided, in standard deviations over the recording and its surrogates together, so that all
//! are exchangeable under the null hypothesis.

use evpose_core::stats::moments::mean_and_deviation;

#[derive(Debug, Clone, Copy)]
pub(super) struct Test {
    /// Whether large values are significant, or small ones.
    pub(super) is_upper: bool,
    /// Whether it counts for the correction.
    pub(super) counts: bool,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Tested {
    pub(super) mean: f64,
    pub(super) sd: f64,
    /// p-value of this test alone.
    pub(super) p: f64,
    /// p-value corrected for all tests that count, if this one does.
    pub(super) adjusted_p: Option<f64>,
}

/// Tests all statistics. `values[r][j]` is statistic `j` of the recording (`r = 0`) or of surrogate
/// `r`.
pub(super) fn test(values: &[Vec<f64>], tests: &[Test]) -> Vec<Tested> {
    let n = values.len() as f64;
    let deviations: Vec<Vec<f64>> = tests
        .iter()
        .enumerate()
        .map(|(j, test)| {
            let column: Vec<f64> = values.iter().map(|row| row[j]).collect();
            // Over recording and surrogates: without an effect, the recording is one of them.
            let (mean, sd) = mean_and_deviation(&column);
            let sign = if test.is_upper { 1.0 } else { -1.0 };
            // Variation within rounding errors is none.
            let scale = if sd > 1e-9 * mean.abs() { sign / sd } else { 0.0 };
            column.iter().map(|value| (value - mean) * scale).collect()
        })
        .collect();
    let counting = || deviations.iter().zip(tests).filter(|(_, test)| test.counts);
    // The largest of all tests by surrogate: that corrects for their number.
    let largest = |r: usize| counting().map(|(column, _)| column[r]).fold(f64::MIN, f64::max);
    let largest: Vec<f64> = (1..values.len()).map(largest).collect();
    let rank = |others: &mut dyn Iterator<Item = f64>, own: f64| {
        // The recording counts as one of its own surrogates.
        (1 + others.filter(|other| *other >= own).count()) as f64 / n
    };
    let tested = deviations.iter().enumerate().map(|(j, column)| {
        let surrogates: Vec<f64> = values[1..].iter().map(|row| row[j]).collect();
        let (mean, sd) = mean_and_deviation(&surrogates);
        let own = column[0];
        let p = rank(&mut column[1..].iter().copied(), own);
        let adjusted_p = tests[j].counts.then(|| rank(&mut largest.iter().copied(), own));
        Tested { mean, sd, p, adjusted_p }
    });
    tested.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const UPPER: Test = Test { is_upper: true, counts: true };
    const LOWER: Test = Test { is_upper: false, counts: true };

    fn assert_p(actual: Option<f64>, expected: f64) {
        assert!(actual.is_some_and(|p| (p - expected).abs() < 1e-12), "{actual:?}");
    }

    #[test]
    fn the_most_deviant_of_ten_has_the_least_p() {
        let mut values: Vec<Vec<f64>> =
            (0..10).map(|r| vec![f64::from(r % 3), f64::from(r)]).collect();
        values[0][0] = 9.0;
        let tested = test(&values, &[UPPER, UPPER]);
        assert_p(Some(tested[0].p), 0.1);
        assert_p(tested[0].adjusted_p, 0.1);
        // The smallest is not deviant upwards, but downwards it is.
        assert_p(Some(tested[1].p), 1.0);
        assert_p(tested[1].adjusted_p, 1.0);
        assert_p(Some(test(&values, &[UPPER, LOWER])[1].p), 0.1);
    }

    #[test]
    fn a_repeated_test_does_not_count() {
        // The second statistic is the largest once in the recording and four times elsewhere.
        let values: Vec<Vec<f64>> =
            (0..10).map(|r| vec![f64::from(u8::from(r == 0)), f64::from(r % 2)]).collect();
        let second = Test { counts: false, ..UPPER };
        let tested = test(&values, &[UPPER, second]);
        assert_p(tested[0].adjusted_p, 0.1);
        assert_eq!(tested[1].adjusted_p, None);
    }

    #[test]
    fn what_never_varies_is_never_deviant() {
        let values = vec![vec![0.3, 1.0], vec![0.3, 2.0], vec![0.3, 0.0]];
        assert_p(Some(test(&values, &[UPPER, UPPER])[0].p), 1.0);
    }
}
