//! The statistics that measurements, searches and reports share, each under its textbook name.
//!
//! * [`quantile`]: order statistics, one function for each rule; medians, outliers, histograms.
//! * [`moments`]: means and standard deviations.
//! * [`distribution`]: tails of the normal, Student's t and Kolmogorov distributions.
//! * [`interval`]: [`Interval`](interval::Interval), t intervals, Wilson intervals, intervals of medians.
//! * [`bootstrap`]: percentile intervals by resampling whole sequences.
//! * [`linear`]: small dense systems of linear equations.
//!
//! Sums run in the order of the values, and no function changes its rule with the size of a sample,
//! so equal inputs give equal bits.
//!
//! ```
//! use evpose_core::stats::interval::{t_interval, wilson};
//! use evpose_core::stats::quantile;
//!
//! // Times of five runs in milliseconds.
//! let mut times_ms = [12.0, 10.0, 14.0, 11.0, 13.0];
//! times_ms.sort_by(f64::total_cmp);
//! assert_eq!(quantile::nearest_rank(&times_ms, 0.5), 12.0);
//! assert_eq!(quantile::linear(&times_ms, 0.9), 13.6);
//!
//! let mean = t_interval(&times_ms).unwrap();
//! assert_eq!(mean.estimate, 12.0);
//! assert!((mean.high.unwrap() - 13.963).abs() < 1e-3);
//!
//! // 8 successes of 10.
//! let (low, high) = wilson(8, 10);
//! assert!((low - 0.490).abs() < 1e-3 && (high - 0.943).abs() < 1e-3);
//! ```

pub mod bootstrap;
pub mod distribution;
pub mod interval;
pub mod linear;
pub mod moments;
pub mod quantile;
