//! Confidence intervals of 95 %.

use serde::{Deserialize, Serialize};

use crate::stats::distribution::{NORMAL_975, student_975};
use crate::stats::moments::{mean, standard_error};

/// Probability that an interval misses its statistic, both sides together.
const MISS: f64 = 0.05;

/// An estimate and its 95% interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// The statistic of the whole sample.
    pub estimate: f64,
    /// Lower end; none where the sample is too small for an interval.
    pub low: Option<f64>,
    /// Upper end; none where the sample is too small for an interval.
    pub high: Option<f64>,
}

impl Interval {
    /// An estimate without an interval.
    pub const fn point(estimate: f64) -> Self {
        Self { estimate, low: None, high: None }
    }
}

/// Student's t interval of a mean: `mean ± t s / √n`, with `n - 1` degrees of freedom.
///
/// One value has a mean without an interval, an empty sample neither. For a few whole training runs
/// this is the interval to use: a bootstrap of three runs has ten distinct samples and is far too
/// short, while t assumes that runs are about normal and widens by a factor of 4.3.
///
/// # Source
/// Student: *The probable error of a mean*, Biometrika 6, 1908.
pub fn t_interval(values: &[f64]) -> Option<Interval> {
    let estimate = mean(values);
    match values.len() {
        0 => None,
        1 => Some(Interval::point(estimate)),
        n => {
            let half = student_975(n - 1) * standard_error(values);
            Some(Interval { estimate, low: Some(estimate - half), high: Some(estimate + half) })
        }
    }
}

/// Wilson score interval of a proportion; 0 to 1 without trials.
///
/// # Source
/// Wilson, J. Am. Stat. Assoc. 22, 1927.
pub fn wilson(successes: usize, trials: usize) -> (f64, f64) {
    if trials == 0 {
        return (0.0, 1.0);
    }
    let (z, n) = (NORMAL_975, trials as f64);
    let p = successes as f64 / n;
    let middle = p + z * z / (2.0 * n);
    let half = z * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + z * z / n;
    // Rounding must not leave the range of a proportion.
    (((middle - half) / scale).max(0.0), ((middle + half) / scale).min(1.0))
}

/// Values of `n` sorted ones that lie outside, on each side, of the narrowest interval of order
/// statistics that misses the median with a probability of at most 5 %.
///
/// The interval is `sorted[k]` to `sorted[n - 1 - k]`. Below six values no interval is wide enough;
/// it is then that of the smallest and the largest.
///
/// # Source
/// Conover, *Practical nonparametric statistics*, 1999, section 3.2.
pub fn median_outer_count(n: usize) -> usize {
    // Logarithm of the probability of `k` heads, and probability of at most `k`, in `n` throws of a
    // fair coin: the first itself underflows from 1,075 throws on.
    let (mut log_chance, mut at_most, mut outer) = (-(n as f64) * std::f64::consts::LN_2, 0.0, 0);
    for k in 0..n / 2 {
        at_most += log_chance.exp();
        if 2.0 * at_most > MISS {
            break;
        }
        outer = k + 1;
        // Each binomial probability follows from the last, without factorials that overflow.
        log_chance += ((n - k) as f64 / (k + 1) as f64).ln();
    }
    outer.saturating_sub(1)
}

/// Indices of the order statistics that bound the median of `n` sorted values, by the normal
/// approximation of the binomial distribution: `n / 2 ± 1.96 √n / 2`, rounded outwards.
///
/// # Panics
/// For an empty sample.
pub fn median_bound_indices(n: usize) -> [usize; 2] {
    let half = 0.5 * NORMAL_975 * (n as f64).sqrt();
    let index = |rank: f64| (rank.max(0.0) as usize).min(n - 1);
    [index((0.5 * n as f64 - half).floor() - 1.0), index((0.5 * n as f64 + half).ceil())]
}

#[cfg(test)]
mod tests {
    use crate::CounterRng;

    use super::*;

    #[test]
    fn three_values_have_the_t_interval_of_the_tables() {
        // Mean 2, standard deviation 1: 4.303 / sqrt(3) to either side.
        let interval = t_interval(&[1.0, 2.0, 3.0]).expect("three values");
        assert_eq!(interval.estimate, 2.0);
        let half = interval.high.expect("three values") - 2.0;
        assert!((half - 2.4843).abs() < 1e-3, "{half}");
        let low = interval.low.expect("three values");
        assert!((low - (2.0 - half)).abs() < 1e-12, "{low}");
    }

    #[test]
    fn t_intervals_cover_the_mean_nineteen_times_in_twenty() {
        let experiments = 4_000;
        let covers = |&seed: &u64| {
            let mut rng = CounterRng::new(seed, "runs", 0);
            let runs = [(); 3].map(|()| f64::from(rng.normal()));
            let interval = t_interval(&runs).expect("three runs");
            interval.low.expect("three") <= 0.0 && 0.0 <= interval.high.expect("three")
        };
        let hits = (0..experiments).filter(covers).count();
        // 95% is 3800, with a standard deviation of 14.
        assert!((3744..=3856).contains(&hits), "{hits} of {experiments}");
    }

    #[test]
    fn one_value_has_no_interval_and_none_has_no_mean() {
        assert_eq!(t_interval(&[7.0]), Some(Interval::point(7.0)));
        assert_eq!(t_interval(&[]), None);
    }

    #[test]
    fn intervals_of_proportions_are_those_of_wilson() {
        // 8 of 10: 0.490 to 0.943, as in every table.
        let (low, high) = wilson(8, 10);
        assert!((low - 0.4902).abs() < 1e-4 && (high - 0.9433).abs() < 1e-4);
        let (low, high) = wilson(0, 5);
        assert!(low == 0.0 && (high - 0.4345).abs() < 1e-4);
        assert_eq!(wilson(0, 0), (0.0, 1.0));
    }

    #[test]
    fn intervals_of_medians_are_those_of_the_tables() {
        // Conover's table A3: ranks 1 and 6, 2 and 9, 6 and 15 of 6, 10 and 20 values.
        assert_eq!([3, 6, 10, 20].map(median_outer_count), [0, 0, 1, 5]);
        // Of many values, by the normal approximation: 1000 less 0.98 √2000.
        assert!((954..=957).contains(&median_outer_count(2_000)));
        // Ranks 40 and 61 of 100, as in the tables.
        assert_eq!(median_bound_indices(100), [39, 60]);
        assert_eq!(median_bound_indices(1), [0, 0]);
    }
}
