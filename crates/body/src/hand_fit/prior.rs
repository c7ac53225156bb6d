//! The hands that are expected before anything is seen of them.
//!
//! # Model
//! Angles of a hand are normal, with the mean and the covariance of the [`GESTURES`]: fingers bend together, a DIP
//! joint with its PIP joint. Every angle may deviate by itself from what the others say of it.

use evpose_core::stats::linear::solve;

use super::ANGLES;
use crate::fingers::{GESTURES, HandAngles};

/// Standard deviation of an angle by itself: as much as gestures vary from hand to hand.
const OWN_SD_DEG: f64 = 9.0;

/// A normal distribution of the angles of hands.
#[derive(Debug, Clone)]
pub(super) struct AnglePrior {
    /// Digit by digit, in radians.
    pub(super) mean: [f32; ANGLES],
    /// The inverse of the covariance.
    pub(super) precision: Vec<Vec<f64>>,
}

impl AnglePrior {
    /// That of the gestures, each as likely as any other.
    pub(super) fn of_gestures() -> Self {
        let hands = GESTURES.map(|gesture| flat(&gesture.angles()));
        let count = hands.len() as f64;
        let average =
            |of: &dyn Fn(&[f32; ANGLES]) -> f64| hands.iter().map(of).sum::<f64>() / count;
        let mean: [f64; ANGLES] = std::array::from_fn(|i| average(&|hand| f64::from(hand[i])));
        let off = |hand: &[f32; ANGLES], i: usize| f64::from(hand[i]) - mean[i];
        let own = OWN_SD_DEG.to_radians().powi(2);
        let covariance = |i: usize, j: usize| {
            average(&|hand| off(hand, i) * off(hand, j)) + if i == j { own } else { 0.0 }
        };
        let matrix: Vec<Vec<f64>> =
            (0..ANGLES).map(|i| (0..ANGLES).map(|j| covariance(i, j)).collect()).collect();
        let unit = |i: usize| (0..ANGLES).map(|j| if i == j { 1.0 } else { 0.0 }).collect();
        // Positive definite by the variance of each angle by itself; a covariance is symmetric, so columns are rows.
        let inverse = (0..ANGLES).map(|i| {
            solve(matrix.clone(), unit(i)).unwrap_or_else(|| unreachable!("a singular covariance"))
        });
        Self { mean: mean.map(|angle| angle as f32), precision: inverse.collect() }
    }
}

/// The angles of a hand digit by digit.
pub(super) fn flat(hand: &HandAngles) -> [f32; ANGLES] {
    std::array::from_fn(|i| hand.digits[i / 4][i % 4])
}
