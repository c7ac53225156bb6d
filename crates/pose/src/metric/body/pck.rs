//! The share of correct joints of a body, and the area under its curve.
//!
//! # Model
//! A joint is correct at the threshold `T` if its error is at most `T` times the size of the body:
//! its torso's diagonal, or its head. `PCK(T)` is the share of correct ones. It is taken at the
//! thresholds 0.01, 0.02, …, 1, and `AUC = Σ PCK(T) / 100` is their mean, a sum of right ends for
//! the integral from 0 to 1: perfect predictions score 1.
//!
//! The published program compares with `≤`, and so does this. The paper's formula is strict; the
//! two differ for errors that lie exactly on a threshold only.
//!
//! # Source
//! PCK by the torso's diagonal: Sapp and Taskar, *MODEC*, CVPR 2013, and MoveEnet's `PCK`. The area
//! as mean over even thresholds: Mehta et al., *Monocular 3D human pose estimation in the wild
//! using improved CNN supervision*, 3DV 2017; MoveEnet publishes none.

use crate::metric::pck::ErrorCounts;

/// How many thresholds the curve has: whole percents of the size.
pub const BODY_THRESHOLDS: usize = 100;

/// Errors of bodies at these thresholds, number `i` at `i + 1` percent.
pub type BodyPck = ErrorCounts<BODY_THRESHOLDS>;

impl BodyPck {
    /// Adds an error of a body of this size, both in pixels. An infinite one is wrong at all
    /// thresholds.
    pub fn push(&mut self, error_px: f64, size_px: f64) {
        // A first guess, at most one off by rounding; the comparison itself decides.
        let guess = (100.0 * error_px / size_px).clamp(0.0, BODY_THRESHOLDS as f64) as usize;
        let reaches = |percent: &usize| error_px <= size_px * (*percent as f64 / 100.0);
        let first = (guess.saturating_sub(1).max(1)..=BODY_THRESHOLDS).find(reaches);
        self.count(first.map(|percent| percent - 1));
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn pck_from_errors(errors: &[f64], size_px: f64) -> BodyPck {
        let mut pck = BodyPck::new();
        errors.iter().for_each(|error| pck.push(*error, size_px));
        pck
    }

    #[test]
    fn an_error_on_a_threshold_is_correct() {
        let pck = pck_from_errors(&[40.0], 100.0);
        assert_eq!((pck.correct(39).sum, pck.correct(40).sum), (0.0, 1.0));
        // 40 to 100 percent.
        assert_eq!(pck.area().mean(), Some(0.61));
    }

    #[test]
    fn perfect_predictions_score_one_and_lost_ones_nothing() {
        assert_eq!(pck_from_errors(&[0.0; 4], 70.0).area().mean(), Some(1.0));
        let lost = pck_from_errors(&[70.1, f64::INFINITY, f64::NAN], 70.0);
        assert_eq!((lost.len(), lost.area().mean()), (3, Some(0.0)));
        assert!(BodyPck::new().curve().is_empty());
    }

    #[test]
    fn uniform_errors_have_the_area_of_a_triangle() {
        let errors: Vec<_> = (0..100_000).map(|i| (f64::from(i) + 0.5) * 1e-3).collect();
        let pck = pck_from_errors(&errors, 100.0);
        assert!((pck.area().mean().unwrap() - 0.505).abs() < 1e-9);
        for (i, share) in pck.curve().into_iter().enumerate() {
            assert!((share - (i + 1) as f64 / 100.0).abs() < 1e-9, "{i}: {share}");
        }
    }

    proptest! {
        #[test]
        fn the_curve_is_the_count_at_every_threshold(
            errors in prop::collection::vec(prop_oneof![0.0..120.0, (0..140).prop_map(f64::from)], 1..40),
            size_px in prop_oneof![Just(100.0), 1.0..200.0],
        ) {
            let pck = pck_from_errors(&errors, size_px);
            for percent in 1..=BODY_THRESHOLDS {
                let limit = size_px * (percent as f64 / 100.0);
                let correct = errors.iter().filter(|&&error| error <= limit).count();
                prop_assert_eq!(pck.correct(percent).sum, correct as f64);
            }
            let mean = pck.curve().iter().sum::<f64>() / BODY_THRESHOLDS as f64;
            prop_assert!((pck.area().mean().unwrap() - mean).abs() < 1e-12);
        }

        #[test]
        fn merged_sequences_are_one(
            a in prop::collection::vec(0.0..90.0, 0..20), b in prop::collection::vec(0.0..90.0, 0..20),
        ) {
            let mut merged = pck_from_errors(&a, 50.0);
            merged.merge(&pck_from_errors(&b, 50.0));
            prop_assert_eq!(merged, pck_from_errors(&[a, b].concat(), 50.0));
        }
    }
}
