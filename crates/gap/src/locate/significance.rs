//! Significance of many deviations at a false discovery rate, and of a maximum.

use evpose_core::stats::distribution::normal_upper_tail;
use evpose_core::stats::moments::mean_and_deviation;

use crate::discovery_rate::discoveries as of_p;

/// Marks the deviations that are significant at the false discovery rate, two-sided.
pub(super) fn discoveries(z: &[f64]) -> Vec<bool> {
    let p: Vec<f64> = z.iter().map(|z| 2.0 * normal_upper_tail(z.abs())).collect();
    of_p(&p)
}

/// Probability of a maximum of at least `maximum` by chance, given maxima `null` by chance: the
/// tail of a Gumbel distribution of the same moments, wider if they are few.
///
/// # Source
/// Abrams, Kulldorff, Kleinman: *Gumbel based p-value approximations for spatial scan statistics*,
/// Int. J. Health Geographics 9, 2010.
pub(super) fn chance_of_maximum(maximum: f64, null: &[f64]) -> f64 {
    /// Mean of the standard Gumbel distribution.
    const EULER: f64 = 0.577_215_664_901_532_9;
    let n = null.len() as f64;
    let (mean, sd) = mean_and_deviation(null);
    // A likelihood ratio of events that are independent has a scale of one.
    let scale = (sd * 6f64.sqrt() / std::f64::consts::PI * (1.0 + 2.0 / n)).max(1.0);
    let place = mean - EULER * scale;
    -(-(-(maximum - place) / scale).exp()).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discoveries_are_those_of_a_worked_example() {
        // p = 0.001, 0.008, 0.039, 0.6: limits are 0.0125, 0.025, 0.0375 and 0.05.
        assert_eq!(discoveries(&[3.29, -2.652, 2.064, 0.524]), [true, true, false, false]);
        assert_eq!(discoveries(&[]), Vec::<bool>::new());
    }

    #[test]
    fn a_maximum_like_those_by_chance_is_no_surprise() {
        let null = [9.0, 11.0, 10.0, 12.0, 8.0];
        let p = chance_of_maximum(10.0, &null);
        assert!((0.2..0.8).contains(&p), "{p}");
        assert!(chance_of_maximum(60.0, &null) < 1e-6);
        assert!(chance_of_maximum(12.0, &null) > chance_of_maximum(13.0, &null));
    }
}
