//! One pole of a filter, advanced exactly over a step in which its input runs in a line.
//!
//! # Model
//! `τ dy/dt = x - y` with `x` from `x0` to `x1` in `dt = a τ`:
//! `y1 = x1 + (y0 - x0) e^-a - (x1 - x0) (1 - e^-a) / a`. For inputs that are not lines the error
//! falls with the square of the step.

use crate::exponential::decay;

#[derive(Debug, Clone, Copy)]
pub(super) struct Pole {
    /// `e^-a`.
    pub(super) left: f32,
    /// `(1 - e^-a) / a`.
    pub(super) mean_left: f32,
}

impl Pole {
    /// A step of `a` time constants.
    #[inline(always)]
    pub(super) fn from_step(a: f32) -> Self {
        // A step of no length leaves all, and keeps the quotient finite.
        let a = if a > 1e-20 { a } else { 1e-20 };
        let gone = decay(a);
        Self { left: 1.0 - gone, mean_left: gone / a }
    }

    /// The output after the step.
    #[inline(always)]
    pub(super) fn low(self, y0: f32, x0: f32, x1: f32) -> f32 {
        x1 + (y0 - x0) * self.left - (x1 - x0) * self.mean_left
    }

    /// Output of the complementary high-pass filter after the step.
    #[inline(always)]
    pub(super) fn high(self, y0: f32, x0: f32, x1: f32) -> f32 {
        y0 * self.left + (x1 - x0) * self.mean_left
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_is_followed_exactly() {
        // τ = 1, x = t from t = 0, y(0) = 0: y = t - 1 + e^-t.
        for a in [1e-4f32, 0.01, 0.5, 3.0, 20.0] {
            let exact = f64::from(a) - 1.0 + f64::from(-a).exp();
            let found = f64::from(Pole::from_step(a).low(0.0, 0.0, a));
            assert!((found - exact).abs() < 1e-6 * f64::from(a), "{a}: {found} {exact}");
            let high = f64::from(Pole::from_step(a).high(0.0, 0.0, a));
            assert!((high + f64::from(-a).exp_m1()).abs() < 1e-6, "{a}");
        }
    }

    #[test]
    fn no_time_changes_nothing() {
        assert_eq!(Pole::from_step(0.0).low(0.3, 0.7, 0.7), 0.3);
        assert_eq!(Pole::from_step(0.0).high(0.3, 0.7, 0.7), 0.3);
    }
}
