//! A curve of the recording, of the model and of the corrected model.

use evpose_core::stats::moments::mean_and_deviation;
use serde::{Deserialize, Serialize};

use super::gaps;

/// Scale of an axis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AxisScale {
    /// Linear.
    #[default]
    Linear,
    /// Logarithmic.
    Log,
}

/// A measured curve with the band of runs of the model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Plot {
    /// Title.
    pub title: String,
    /// Explanation in a sentence.
    pub caption: String,
    /// Name and unit of the horizontal axis.
    pub x_name: String,
    /// Scale of the horizontal axis.
    pub x_scale: AxisScale,
    /// Name and unit of the vertical axis.
    pub y_name: String,
    /// Scale of the vertical axis.
    pub y_scale: AxisScale,
    /// Positions on the horizontal axis; the curves have one value at each. An unknown value is
    /// NaN.
    #[serde(with = "gaps")]
    pub x: Vec<f64>,
    /// Measured curve.
    #[serde(with = "gaps")]
    pub measured: Vec<f64>,
    /// Lower edge of the band of runs of the model.
    #[serde(with = "gaps")]
    pub low: Vec<f64>,
    /// Upper edge of the band.
    #[serde(with = "gaps")]
    pub high: Vec<f64>,
    /// Mean of runs of the corrected model; empty if there is none.
    #[serde(with = "gaps", default)]
    pub corrected: Vec<f64>,
}

impl Plot {
    /// Sets the measured curve, the band from runs of the model (mean and two standard deviations
    /// to either side), and the mean of the corrected model.
    #[must_use]
    pub fn with(mut self, measured: Vec<f64>, runs: &[Vec<f64>], corrected: &[Vec<f64>]) -> Self {
        let is_log = self.y_scale == AxisScale::Log;
        let (mut low, mut high) = (Vec::new(), Vec::new());
        for i in 0..measured.len() {
            let values: Vec<f64> = known(runs, i).collect();
            let (mean, sd) = mean_and_deviation(&values);
            let min = values.iter().copied().fold(f64::INFINITY, f64::min);
            // On a logarithmic axis an edge below zero is replaced by the smallest run.
            let edge = mean - 2.0 * sd;
            low.push(if is_log && edge <= 0.0 { min.min(mean) } else { edge });
            high.push(mean + 2.0 * sd);
        }
        let mean = |i: usize| mean_and_deviation(&known(corrected, i).collect::<Vec<_>>()).0;
        self.corrected = match corrected.is_empty() {
            true => Vec::new(),
            false => (0..measured.len()).map(mean).collect(),
        };
        (self.measured, self.low, self.high) = (measured, low, high);
        self
    }
}

fn known(runs: &[Vec<f64>], i: usize) -> impl Iterator<Item = f64> {
    runs.iter().map(move |run| run[i]).filter(|value| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_is_two_standard_deviations_without_unknown_values() {
        let runs = [vec![1.0, f64::NAN], vec![3.0, f64::NAN], vec![2.0, 7.0]];
        let plot = Plot::default().with(vec![2.0, f64::NAN], &runs, &[vec![2.5, 6.0]]);
        assert_eq!((plot.low[0], plot.high[0]), (0.0, 4.0));
        assert_eq!((plot.low[1], plot.high[1]), (7.0, 7.0));
        assert_eq!(plot.corrected, [2.5, 6.0]);
        let json = serde_json::to_string(&plot).unwrap();
        let back: Plot = serde_json::from_str(&json).unwrap();
        assert!(back.measured[1].is_nan() && back.measured[0] == 2.0, "{json}");
    }
}
