//! The hands that are expected before anything is seen of them.
//!
//! # Model
//! Angles of a hand are normal, with the mean and the covariance of the [`GESTURES`], by which simulated hands move, and,
//! a third, of real hands: fingers bend together, a DIP joint with its PIP joint. Every angle may deviate by itself
//! from what the others say of it.
//!
//! # Source
//! Real hands: 10,508 of people who spell letters, `borisgraudt/asl-ai` (CC0-1.0), of which
//! `examples/real_hands.rs` made `real_hands.txt`.

use evpose_core::stats::linear::solve;

use super::ANGLES;
use crate::fingers::{GESTURES, HandAngles};

/// Standard deviation of an angle by itself: as much as gestures vary from hand to hand.
const OWN_SD_DEG: f64 = 9.0;
/// How much of the distribution is that of real hands.
const REAL_SHARE: f64 = 1.0 / 3.0;
/// The mean angles of real hands in degrees, then the lower half of their covariance, a line a row.
const REAL_HANDS: &str = include_str!("real_hands.txt");

/// A normal distribution of the angles of hands.
#[derive(Debug, Clone)]
pub(super) struct AnglePrior {
    /// Digit by digit, in radians.
    pub(super) mean: [f32; ANGLES],
    /// The inverse of the covariance.
    pub(super) precision: Vec<Vec<f64>>,
}

/// Mean and second moments of angles, in radians.
struct Moments {
    mean: [f64; ANGLES],
    second: [[f64; ANGLES]; ANGLES],
}

impl Moments {
    /// Those of the gestures, each as likely as any other.
    fn of_gestures() -> Self {
        let hands = GESTURES.map(|gesture| flat(&gesture.angles()).map(f64::from));
        let average = |of: &dyn Fn(&[f64; ANGLES]) -> f64| {
            hands.iter().map(of).sum::<f64>() / hands.len() as f64
        };
        Self {
            mean: std::array::from_fn(|i| average(&|hand| hand[i])),
            second: std::array::from_fn(|i| {
                std::array::from_fn(|j| average(&|hand| hand[i] * hand[j]))
            }),
        }
    }

    /// Those of real hands.
    fn of_real_hands() -> Self {
        let rows: Vec<Vec<f64>> = REAL_HANDS
            .lines()
            .map(|line| {
                line.split(' ')
                    .map(|value| {
                        value.parse().unwrap_or_else(|_| unreachable!("no value: {value}"))
                    })
                    .collect()
            })
            .collect();
        let radians = 1f64.to_radians();
        let mean: [f64; ANGLES] = std::array::from_fn(|i| radians * rows[0][i]);
        let covariance = |i: usize, j: usize| radians * radians * rows[1 + i.max(j)][i.min(j)];
        let second =
            std::array::from_fn(|i| std::array::from_fn(|j| covariance(i, j) + mean[i] * mean[j]));
        Self { mean, second }
    }
}

impl AnglePrior {
    /// That of all hands there are.
    pub(super) fn new() -> Self {
        let (a, b) = (Moments::of_gestures(), Moments::of_real_hands());
        let mix = |gestures: f64, real: f64| gestures + REAL_SHARE * (real - gestures);
        let mean: [f64; ANGLES] = std::array::from_fn(|i| mix(a.mean[i], b.mean[i]));
        let own = OWN_SD_DEG.to_radians().powi(2);
        let covariance = |i: usize, j: usize| {
            let second = mix(a.second[i][j], b.second[i][j]);
            second - mean[i] * mean[j] + if i == j { own } else { 0.0 }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn real_hands_bend_their_fingers_together() {
        let Moments { mean, second } = Moments::of_real_hands();
        assert_eq!(REAL_HANDS.lines().count(), 1 + ANGLES);
        let covariance = |i: usize, j: usize| second[i][j] - mean[i] * mean[j];
        let correlation =
            |i: usize, j: usize| covariance(i, j) / (covariance(i, i) * covariance(j, j)).sqrt();
        // Flexions of ring finger and pinky at MCP and PIP joints: tendons connect them.
        assert!(correlation(4 * 3 + 1, 4 * 4 + 1) > 0.5);
        assert!(correlation(4 * 3 + 2, 4 * 4 + 2) > 0.5);
        let limits = |i: usize| HandAngles::limits(i / 4, i % 4).map(f64::from);
        for (i, mean) in mean.into_iter().enumerate() {
            assert!((limits(i)[0]..limits(i)[1]).contains(&mean), "{i}: {mean}");
        }
    }
}
