//! Nonlinear least squares: Gauss-Newton with Levenberg-Marquardt damping and numeric Jacobians.
//!
//! # Source
//! Marquardt, *An algorithm for least-squares estimation of nonlinear parameters*, SIAM J. 11(2),
//! 1963: damping by the diagonal of the normal matrix, a tenth or ten times as much after each step.

use evpose_core::stats::linear::solve;

/// Damping at the start, relative to the diagonal.
const FIRST_DAMPING: f64 = 1e-3;
/// Damping at which no step is small enough to help: the minimum is reached.
const MAX_DAMPING: f64 = 1e8;
/// Relative decrease of the cost at which the iteration ends.
const CONVERGED: f64 = 1e-6;
/// Smallest diagonal entry: parameters without influence stay where they are.
const MIN_DIAGONAL: f64 = 1e-12;

/// The result of a minimisation.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Minimum {
    /// Parameters.
    pub(super) parameters: Vec<f64>,
    /// Sum of the squared residuals.
    pub(super) cost: f64,
}

/// Minimises the sum of squares of `residuals`, which writes as many values at each call, from
/// `start` in at most `iterations` steps. `increments` are those of the numeric derivatives; a
/// parameter of increment 0 is fixed.
pub(super) fn minimise(
    residuals: &mut dyn FnMut(&[f64], &mut Vec<f64>),
    start: &[f64],
    increments: &[f64],
    iterations: usize,
) -> Minimum {
    // Parameters that are fixed have no derivative and no place in the equations.
    let free: Vec<usize> = (0..start.len()).filter(|k| increments[*k] > 0.0).collect();
    let mut parameters = start.to_vec();
    let (mut current, mut shifted) = (Vec::new(), Vec::new());
    residuals(&parameters, &mut current);
    let mut cost = sum_of_squares(&current);
    let mut damping = FIRST_DAMPING;
    for _ in 0..iterations {
        let jacobian: Vec<Vec<f64>> = free
            .iter()
            .map(|&k| {
                let mut column = derivative(residuals, &parameters, k, increments[k], &mut shifted);
                column.resize(current.len(), 0.0);
                column
            })
            .collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let normal: Vec<Vec<f64>> =
            jacobian.iter().map(|a| jacobian.iter().map(|b| dot(a, b)).collect()).collect();
        // The negative gradient: steps go downhill.
        let gradient: Vec<f64> = jacobian.iter().map(|column| -dot(column, &current)).collect();
        let before = cost;
        while damping < MAX_DAMPING {
            let mut damped = normal.clone();
            for (k, row) in damped.iter_mut().enumerate() {
                // Marquardt's scaling: relative to each parameter's curvature, which may be zero.
                row[k] += damping * row[k].max(MIN_DIAGONAL);
            }
            let tried = solve(damped, gradient.clone()).map(|step| {
                let mut tried = parameters.clone();
                free.iter().zip(step).for_each(|(&k, step)| tried[k] += step);
                tried
            });
            // Equations without a solution are damped more.
            if let Some(tried) = tried {
                residuals(&tried, &mut shifted);
                let tried_cost = sum_of_squares(&shifted);
                if tried_cost < cost {
                    (parameters, cost) = (tried, tried_cost);
                    std::mem::swap(&mut current, &mut shifted);
                    // Towards Gauss-Newton after a success, towards small steps after a failure.
                    damping = (0.1 * damping).max(1e-9);
                    break;
                }
            }
            damping *= 10.0;
        }
        // The last step lowered the cost by next to nothing, or no step did.
        if before - cost <= CONVERGED * before {
            break;
        }
    }
    Minimum { parameters, cost }
}

/// Central differences of the residuals by parameter `k`.
fn derivative(
    residuals: &mut dyn FnMut(&[f64], &mut Vec<f64>),
    parameters: &[f64],
    k: usize,
    increment: f64,
    scratch: &mut Vec<f64>,
) -> Vec<f64> {
    let mut shifted = parameters.to_vec();
    let mut column = Vec::new();
    // From both sides: the error falls with the square of the increment.
    shifted[k] = parameters[k] + increment;
    residuals(&shifted, &mut column);
    shifted[k] = parameters[k] - increment;
    residuals(&shifted, scratch);
    column.iter_mut().zip(scratch).for_each(|(up, down)| *up = (*up - *down) / (2.0 * increment));
    column
}

fn sum_of_squares(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rosenbrocks_valley_is_followed_to_its_minimum() {
        let mut residuals = |p: &[f64], out: &mut Vec<f64>| {
            out.clear();
            out.extend([10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]]);
        };
        let found = minimise(&mut residuals, &[-1.2, 1.0], &[1e-5, 1e-5], 100);
        assert!(found.cost < 1e-12, "{found:?}");
        assert!(
            (found.parameters[0] - 1.0).abs() < 1e-5 && (found.parameters[1] - 1.0).abs() < 1e-5
        );
    }

    #[test]
    fn fixed_parameters_and_those_without_influence_stay() {
        let mut residuals = |p: &[f64], out: &mut Vec<f64>| {
            out.clear();
            out.extend([p[0] - 3.0, p[0] + p[1] - 5.0]);
        };
        let found = minimise(&mut residuals, &[0.0, 1.0, 7.0], &[1e-4, 0.0, 1e-4], 20);
        assert!((found.parameters[0] - 3.5).abs() < 1e-6, "{found:?}");
        assert_eq!(found.parameters[1..], [1.0, 7.0]);
        assert!((found.cost - 0.5).abs() < 1e-9);
    }
}
