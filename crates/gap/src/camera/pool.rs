//! One value of a camera from those of its recordings.
//!
//! # Method
//! Mean by inverse variance. Where values scatter by more than their intervals, the interval is widened by the square
//! root of chi square over its degrees of freedom (the Birge ratio). Where two of them are further apart than chance
//! allows, there is no mean: recordings of one camera have one value.
//!
//! # Source
//! R. T. Birge: *The calculation of errors by the method of least squares*, Phys. Rev. 40, 1932.

use evpose_core::stats::distribution::{NORMAL_975, normal_upper_tail};
use evpose_core::stats::interval::Interval;

use super::recording::{interval, reach};
use super::{Quantity, Reading, Spec};

/// Probability that recordings of one camera are said to contradict each other.
const CHANCE: f64 = 0.01;
/// Standard error that stands for none, relative to the value.
const MIN_ERROR: f64 = 1e-9;

impl Spec {
    /// The quantity from its readings.
    pub(super) fn pooled(&self, readings: Vec<Reading>) -> Quantity {
        let known: Vec<(&Reading, Interval)> =
            readings.iter().filter_map(|one| Some((one, one.value?))).collect();
        let mut reasons: Vec<&str> = readings.iter().filter_map(|one| one.why.as_deref()).collect();
        reasons.sort_unstable();
        reasons.dedup();
        let (value, why) = match contradiction(&known) {
            _ if known.is_empty() => (None, Some(reasons.join("; "))),
            _ if !self.is_of_camera => (None, None),
            None => (Some(mean(&known)), None),
            why => (None, why),
        };
        let Self { name, is_of_camera, would_show, .. } = *self;
        Quantity { name, is_of_camera, value, why, would_show, readings }
    }
}

fn error(value: &Interval) -> f64 {
    let min = MIN_ERROR * value.estimate.abs() + f64::MIN_POSITIVE;
    (reach(value) / NORMAL_975).max(min)
}

fn mean(known: &[(&Reading, Interval)]) -> Interval {
    if let [(_, only)] = known {
        return *only;
    }
    let sum: f64 = known.iter().map(|(_, one)| error(one).powi(-2)).sum();
    let weighted = known.iter().map(|(_, one)| one.estimate * error(one).powi(-2));
    let mean = weighted.sum::<f64>() / sum;
    let squares = known.iter().map(|(_, one)| ((one.estimate - mean) / error(one)).powi(2));
    let birge = (squares.sum::<f64>() / (known.len() - 1) as f64).sqrt().max(1.0);
    interval(mean, NORMAL_975 * birge / sum.sqrt())
}

/// Two recordings that differ by more than chance among all pairs.
fn contradiction(known: &[(&Reading, Interval)]) -> Option<String> {
    let pairs =
        known.iter().enumerate().flat_map(|(i, a)| known[i + 1..].iter().map(move |b| (a, b)));
    let count = pairs.clone().count() as f64;
    let mut apart = pairs.filter(|((one, a), (other, b))| {
        let z = (a.estimate - b.estimate).abs() / error(a).hypot(error(b));
        one.variant != other.variant || 2.0 * count * normal_upper_tail(z) < CHANCE
    });
    let words = |(reading, value): &(&Reading, Interval)| {
        let variant = reading.variant.unwrap_or_default();
        format!("{:.4} {variant} in {}", value.estimate, reading.recording).replace("  ", " ")
    };
    apart.next().map(|(a, b)| format!("contradictory: {}, {}", words(a), words(b)))
}
