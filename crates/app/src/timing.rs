//! Quantiles and outliers of measured times.

/// Quantile `q` of sorted values (nearest rank).
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let rank = (q * sorted.len() as f64).ceil() as usize;
    sorted[rank.clamp(1, sorted.len()) - 1]
}

/// Number of sorted times with a modified z-score above 3.5 (Iglewicz and Hoaglin 1993): a sign of
/// a machine under load.
pub fn outliers(sorted: &[f64]) -> usize {
    let median = quantile(sorted, 0.5);
    let mut deviations: Vec<f64> = sorted.iter().map(|t| (t - median).abs()).collect();
    deviations.sort_by(f64::total_cmp);
    let spread = quantile(&deviations, 0.5).max(1e-9);
    sorted.iter().filter(|t| 0.6745 * (*t - median).abs() / spread > 3.5).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_nearest_ranks() {
        let values: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!([0.5, 0.95, 0.99, 1.0].map(|q| quantile(&values, q)), [50.0, 95.0, 99.0, 100.0]);
        assert_eq!(quantile(&[7.0], 0.99), 7.0);
    }

    #[test]
    fn a_slow_run_is_an_outlier() {
        let mut values: Vec<f64> = (0..50).map(|i| 10.0 + 0.01 * f64::from(i)).collect();
        assert_eq!(outliers(&values), 0);
        values.push(30.0);
        assert_eq!(outliers(&values), 1);
    }
}
