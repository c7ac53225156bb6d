//! Intervals for the mean of a few whole runs.
//!
//! # Model
//! Student's t interval: `mean ± t s / √n` with the 97.5 percentile of `n - 1` degrees of freedom.
//! A bootstrap of three runs knows ten samples only and is far too short; t assumes that runs are
//! about normal and says so with a factor of 4.3.
//!
//! # Source
//! Student: *The probable error of a mean*, Biometrika 6, 1908. The expansion of the percentile for
//! many runs: Abramowitz and Stegun, *Handbook of Mathematical Functions*, 26.7.5.

use super::Interval;

/// The 97.5 percentiles for 1 to 9 degrees of freedom.
const T_975: [f64; 9] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262];

/// The 97.5 percentile of the normal distribution.
const NORMAL_975: f64 = 1.959_964;

/// The mean of one value a run, with its 95% interval; an interval takes two runs, a mean one.
pub fn mean_of_runs(values: &[f64]) -> Option<Interval> {
    let count = values.len() as f64;
    let estimate = values.iter().sum::<f64>() / count;
    match values.len() {
        0 => None,
        1 => Some(Interval { estimate, low: None, high: None }),
        runs => {
            let squares: f64 = values.iter().map(|value| (value - estimate).powi(2)).sum();
            let half = t_975(runs - 1) * (squares / (count - 1.0) / count).sqrt();
            Some(Interval { estimate, low: Some(estimate - half), high: Some(estimate + half) })
        }
    }
}

fn t_975(degrees: usize) -> f64 {
    T_975.get(degrees - 1).copied().unwrap_or_else(|| {
        let (z, n) = (NORMAL_975, degrees as f64);
        let second = 5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z;
        let third = 3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z;
        let [first, second, third] =
            [(z.powi(3) + z) / (4.0 * n), second / (96.0 * n * n), third / (384.0 * n.powi(3))];
        z + first + second + third
    })
}

#[cfg(test)]
mod tests {
    use evpose_core::CounterRng;

    use super::*;

    #[test]
    fn three_runs_have_the_interval_of_the_tables() {
        // Mean 2, standard deviation 1: 4.303 / sqrt(3) to either side.
        let interval = mean_of_runs(&[1.0, 2.0, 3.0]).expect("three runs");
        assert_eq!(interval.estimate, 2.0);
        let half = interval.high.expect("three runs") - 2.0;
        assert!((half - 2.4843).abs() < 1e-3, "{half}");
        let low = interval.low.expect("three runs");
        assert!((low - (2.0 - half)).abs() < 1e-12, "{low}");
    }

    #[test]
    fn intervals_of_three_runs_hold_the_truth_nineteen_times_in_twenty() {
        let experiments = 4_000;
        let holds = |&seed: &u64| {
            let mut rng = CounterRng::new(seed, "runs", 0);
            let runs = [(); 3].map(|()| f64::from(rng.normal()));
            let interval = mean_of_runs(&runs).expect("three runs");
            interval.low.expect("three") <= 0.0 && 0.0 <= interval.high.expect("three")
        };
        let held = (0..experiments).filter(holds).count();
        // 95% is 3800, with a standard deviation of 14.
        assert!((3744..=3856).contains(&held), "{held} of {experiments}");
    }

    #[test]
    fn the_percentile_goes_on_smoothly_beyond_the_table() {
        // Tables: 2.228 for 10 degrees of freedom, 2.042 for 30.
        assert!((t_975(10) - 2.228).abs() < 1e-3 && (t_975(30) - 2.042).abs() < 1e-3);
        assert!((1..200).all(|n| t_975(n) > t_975(n + 1)));
    }

    #[test]
    fn one_run_has_no_interval_and_none_has_no_mean() {
        let one = mean_of_runs(&[7.0]).expect("one run");
        assert_eq!((one.estimate, one.low, one.high), (7.0, None, None));
        assert_eq!(mean_of_runs(&[]), None);
    }
}
