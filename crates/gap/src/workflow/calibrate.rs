//! Fit of probabilities and of errors to cases whose truth is known.
//!
//! # Method
//! Probabilities: ridge logistic regression, by Newton steps. Features are standardised; slopes
//! have a standard normal prior, the intercept has none. A slope of the wrong sign (a larger gap
//! that makes an identification more probable) is an accident of few cases: its feature is left
//! out.
//!
//! Errors: the factor with which nine of ten 90 % intervals hold the truth, beside a floor that is kept.
//! A single estimate that is far off does not widen all intervals, as it would with a proper score.

use evpose_core::stats::linear::solve;
use evpose_core::stats::quantile::nearest_rank;

use super::calibration::{ErrorScale, FEATURES, FindingEvidence};
use super::findings::SIDE;

/// Columns of the design matrix: a constant and the features.
const COLUMNS: usize = FEATURES.len() + 1;
/// Maximum Newton steps; few are needed.
const STEPS: usize = 50;
/// Sign that each slope must have; zero for either.
const SIGNS: [f64; FEATURES.len()] = [1.0, -1.0];
/// Wrong identifications required per feature beyond the first.
const WRONG_PER_FEATURE: usize = 5;
/// Minimum estimates for a fit of their errors.
const MIN_ESTIMATES: usize = 10;
/// Fraction of intervals that hold the truth.
const COVERAGE: f64 = 0.9;
/// Smallest standard deviation as computed that a factor is formed with, in steps.
const MIN_RAW: f64 = 1e-9;

/// Error of an estimate whose true value is known.
#[derive(Debug, Clone, Copy)]
pub struct EstimateError {
    /// Error in steps of the parameter.
    pub steps: f64,
    /// Its standard deviation as computed, in steps.
    pub raw: f64,
}

/// Fits intercept and slopes to identifications that were right or wrong; none unless both occur.
pub fn fit_probability(cases: &[(FindingEvidence, bool)]) -> Option<(f64, [f64; FEATURES.len()])> {
    let wrong = cases.iter().filter(|(_, is_right)| !is_right).count();
    let mut is_used = [false; FEATURES.len()];
    is_used[..(wrong / WRONG_PER_FEATURE).clamp(1, FEATURES.len())].fill(true);
    loop {
        let (intercept, slopes) = fit_with(cases, &is_used)?;
        let wrong = (0..FEATURES.len()).find(|i| slopes[*i] * SIGNS[*i] < 0.0);
        match wrong {
            // A sign against what the feature means is an accident of few cases: it is left out,
            // not trusted.
            Some(i) => is_used[i] = false,
            None => return Some((intercept, slopes)),
        }
    }
}

fn fit_with(
    cases: &[(FindingEvidence, bool)],
    is_used: &[bool; FEATURES.len()],
) -> Option<(f64, [f64; FEATURES.len()])> {
    // With one outcome alone, the intercept would be infinite: it has no prior.
    let right = cases.iter().filter(|(_, is_right)| *is_right).count();
    if right == 0 || right == cases.len() {
        return None;
    }
    let n = cases.len() as f64;
    let mean = |i: usize| cases.iter().map(|(e, _)| e.features()[i]).sum::<f64>() / n;
    let means: [f64; FEATURES.len()] = std::array::from_fn(mean);
    let spread = |i: usize| {
        let squares = cases.iter().map(|(e, _)| (e.features()[i] - means[i]).powi(2));
        (squares.sum::<f64>() / n).sqrt()
    };
    let spreads: [f64; FEATURES.len()] = std::array::from_fn(spread);
    let row = |evidence: &FindingEvidence| -> [f64; COLUMNS] {
        let features = evidence.features();
        std::array::from_fn(|i| match i.checked_sub(1) {
            None => 1.0,
            Some(i) if is_used[i] && spreads[i] > 1e-9 => (features[i] - means[i]) / spreads[i],
            Some(_) => 0.0,
        })
    };
    let rows: Vec<([f64; COLUMNS], f64)> =
        cases.iter().map(|(e, is_right)| (row(e), f64::from(u8::from(*is_right)))).collect();
    let mut weights = [0.0; COLUMNS];
    for _ in 0..STEPS {
        let mut matrix = vec![vec![0.0; COLUMNS]; COLUMNS];
        let mut gradient = vec![0.0; COLUMNS];
        for (row, label) in &rows {
            let p = logistic(row.iter().zip(&weights).map(|(x, w)| x * w).sum());
            for a in 0..COLUMNS {
                gradient[a] += row[a] * (label - p);
                for b in 0..COLUMNS {
                    matrix[a][b] += row[a] * row[b] * p * (1.0 - p);
                }
            }
        }
        // A normal prior on slopes; the intercept is free.
        matrix[0][0] += 1e-9;
        for a in 1..COLUMNS {
            matrix[a][a] += 1.0;
            gradient[a] -= weights[a];
        }
        let change = solve(matrix, gradient)?;
        // Far from the optimum Newton's steps are too long.
        for (weight, change) in weights.iter_mut().zip(&change) {
            *weight += change.clamp(-2.0, 2.0);
        }
        if change.iter().all(|change| change.abs() < 1e-10) {
            break;
        }
    }
    // Back from standardised features.
    let slopes: [f64; FEATURES.len()] = std::array::from_fn(|i| {
        if is_used[i] && spreads[i] > 1e-9 { weights[i + 1] / spreads[i] } else { 0.0 }
    });
    let shift: f64 = slopes.iter().zip(means).map(|(slope, mean)| slope * mean).sum();
    Some((weights[0] - shift, slopes))
}

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// Fits the factor of errors beside a floor; none for too few estimates.
pub fn fit_errors(errors: &[EstimateError], floor: f64) -> Option<ErrorScale> {
    let needed = |error: &EstimateError| {
        // Errors add in squares: the factor has to cover what the floor does not.
        let beyond = (error.steps / SIDE).powi(2) - floor * floor;
        beyond.max(0.0).sqrt() / error.raw.max(MIN_RAW)
    };
    let mut factors: Vec<f64> = errors.iter().map(needed).filter(|f| f.is_finite()).collect();
    if factors.len() < MIN_ESTIMATES {
        return None;
    }
    factors.sort_by(f64::total_cmp);
    Some(ErrorScale { factor: nearest_rank(&factors, COVERAGE), floor })
}

/// Fraction of 90 % intervals that contain the truth; none without estimates.
pub fn coverage(errors: &[EstimateError], scale: &ErrorScale) -> Option<f64> {
    let inside = errors
        .iter()
        .filter(|error| error.steps.abs() <= SIDE * scale.calibrate(error.raw))
        .count();
    (!errors.is_empty()).then(|| inside as f64 / errors.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use evpose_core::CounterRng;

    fn evidence(log_odds: f64, gap_after: f64) -> FindingEvidence {
        FindingEvidence { log_odds, gap_after }
    }

    #[test]
    fn odds_that_are_twice_too_large_are_halved() {
        let mut rng = CounterRng::new(3, "names", 0);
        let names: Vec<(FindingEvidence, bool)> = (0..20_000)
            .map(|_| {
                let odds = 8.0 * f64::from(rng.unit());
                (evidence(odds, 0.3), f64::from(rng.unit()) < logistic(0.5 * odds - 1.0))
            })
            .collect();
        let (intercept, slopes) = fit_probability(&names).unwrap();
        assert!((slopes[0] - 0.5).abs() < 0.03 && (intercept + 1.0).abs() < 0.1, "{slopes:?}");
        // Constant features have no slope.
        assert_eq!(slopes[1], 0.0);
    }

    #[test]
    fn without_features_the_probability_is_the_share_that_is_right() {
        let names: Vec<_> = (0..100).map(|i| (evidence(2.0, 0.3), i < 80)).collect();
        let (intercept, slopes) = fit_probability(&names).unwrap();
        assert!((logistic(intercept) - 0.8).abs() < 1e-9);
        assert_eq!(slopes, [0.0; 2]);
        assert!(fit_probability(&names[..80]).is_none());
    }

    #[test]
    fn a_slope_of_the_wrong_sign_is_left_out() {
        // Here identifications are right where much of the gap is left.
        let gap = |i: i32| if i % 2 == 0 { 0.2 } else { 2.0 };
        let names: Vec<_> = (0..400).map(|i| (evidence(0.0, gap(i)), i % 2 == 1)).collect();
        let (_, slopes) = fit_probability(&names).unwrap();
        assert_eq!(slopes[1], 0.0);
    }

    #[test]
    fn errors_that_are_three_times_too_small_are_scaled_by_three() {
        let mut rng = CounterRng::new(4, "numbers", 0);
        let errors: Vec<EstimateError> = (0..20_000)
            .map(|_| {
                let raw = 0.2 + f64::from(rng.unit());
                EstimateError { steps: 3.0 * raw * f64::from(rng.normal()), raw }
            })
            .collect();
        let scale = fit_errors(&errors, 0.0).unwrap();
        assert!((scale.factor - 3.0).abs() < 0.1, "{scale:?}");
        assert!((coverage(&errors, &scale).unwrap() - 0.9).abs() < 1e-3);
        assert!(fit_errors(&errors[..5], 0.0).is_none());
    }

    #[test]
    fn a_factor_beside_a_floor_covers_as_many() {
        let mut rng = CounterRng::new(5, "numbers", 0);
        let errors: Vec<EstimateError> = (0..20_000)
            .map(|i| {
                let raw = 0.01 + 0.1 * f64::from(i % 9);
                EstimateError { steps: (2.0 * raw).hypot(0.5) * f64::from(rng.normal()), raw }
            })
            .collect();
        let scale = fit_errors(&errors, 0.5).unwrap();
        assert!((scale.floor - 0.5).abs() < 1e-12 && scale.factor < 2.5, "{scale:?}");
        assert!((coverage(&errors, &scale).unwrap() - 0.9).abs() < 1e-3);
    }
}
