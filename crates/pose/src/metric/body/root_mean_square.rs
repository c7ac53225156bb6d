//! The root mean square error of a point, in pixels and in percent.
//!
//! # Model
//! In pixels: `√(Σ |p - t|² / n)`. In percent: for each coordinate `100 √(Σ (p - t)² / n) / |Σ p /
//! n|`, and the larger of the two. The percentage depends on where in the image somebody stands; it
//! is there to be compared with published ones.
//!
//! # Source
//! hpe-core's `RMSE`.

use glam::DVec2;

/// Sums over predictions `p` of a true point `t`. They add up over sequences.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RootMeanSquare {
    /// How many.
    pub count: u64,
    /// `Σ (p - t)²` for each coordinate.
    pub squares: DVec2,
    /// `Σ p`.
    pub predicted: DVec2,
}

impl RootMeanSquare {
    /// Adds a prediction.
    pub fn push(&mut self, predicted: DVec2, truth: DVec2) {
        self.count += 1;
        self.squares += (predicted - truth) * (predicted - truth);
        self.predicted += predicted;
    }

    /// Adds those of another sequence.
    pub fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.squares += other.squares;
        self.predicted += other.predicted;
    }

    /// In the unit of the points, if anything was measured.
    pub fn length(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.squares.element_sum() / self.count as f64).sqrt())
    }

    /// In percent of the mean prediction, if that is not 0.
    pub fn percent(&self) -> Option<f64> {
        let count = self.count as f64;
        let root = (self.squares / count).map(f64::sqrt);
        let percent = 100.0 * (root / (self.predicted / count).abs()).max_element();
        (self.count > 0 && percent.is_finite()).then_some(percent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_error_is_its_own_root_mean_square() {
        let (mut whole, mut half) = (RootMeanSquare::default(), RootMeanSquare::default());
        for k in 0..10 {
            let truth = DVec2::new(97.0 + 2.0 * f64::from(k % 2), 46.0);
            // Around (101, 50).
            let predicted = truth + DVec2::new(3.0, 4.0);
            whole.push(predicted, truth);
            if k < 5 {
                half.push(predicted, truth);
            }
        }
        assert!((whole.length().unwrap() - 5.0).abs() < 1e-12);
        assert!((whole.percent().unwrap() - 100.0 * 4.0 / 50.0).abs() < 1e-12);
        half.merge(&half.clone());
        assert_eq!(half.count, 10);
        assert!((half.length().unwrap() - 5.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_has_no_error_and_a_mean_of_zero_no_percentage() {
        assert_eq!(RootMeanSquare::default().length(), None);
        assert_eq!(RootMeanSquare::default().percent(), None);
        let mut zero = RootMeanSquare::default();
        zero.push(DVec2::ZERO, DVec2::ONE);
        assert_eq!(
            (zero.length().map(f64::to_bits), zero.percent()),
            (Some(2f64.sqrt().to_bits()), None)
        );
    }
}
