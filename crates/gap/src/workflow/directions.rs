//! Directions of effects in the space of summary statistics: detection limits, and effects that are
//! alike.
//!
//! # Method
//! The first part of the recording is simulated with each candidate added to the model, at its
//! detection limit. The change of the summary, in standard deviations, is its direction. The
//! fraction of a disagreement in the span of the directions of a domain measures how near it is to
//! that domain.

use std::collections::BTreeMap;

use evpose_sensor::{Scale, SensorConfig, Strength};
use rayon::prelude::*;

use crate::candidate::{Candidate, Trial};
use crate::compare::Expectation;
use crate::{GapError, Objective, discrepancy};

/// Discrepancy that is detectable: about twice the minimum gain of an accepted effect.
const DETECTABLE: f64 = 60.0;

/// Minimum squared remainder of a direction, relative to its square, that extends a basis.
const MIN_REMAINDER: f64 = 1e-3;
/// Largest change of a statistic, standard deviations.
const MAX_CHANGE: f64 = 100.0;

/// Direction of one candidate.
#[derive(Debug, Clone)]
pub struct Direction {
    /// Name in the catalogue.
    pub name: &'static str,
    /// Domain of the signal chain.
    pub domain: &'static str,
    /// Parameter that is its strength.
    pub parameter: &'static str,
    /// Unit of the strength.
    pub unit: &'static str,
    /// Detection limit; none if no strength is detectable.
    pub limit: Option<f64>,
    /// Strongest value that was tried.
    pub strongest: f64,
    /// Change of the summary in standard deviations, at the detection limit or the strongest value.
    pub change: Vec<f64>,
}

/// Directions of all candidates.
#[derive(Debug, Clone)]
pub struct Directions {
    /// Directions in the order of the catalogue.
    pub all: Vec<Direction>,
}

impl Directions {
    /// Simulates every candidate added to a model.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn simulate(
        objective: &Objective<'_>,
        model: &SensorConfig,
        left_out: &[String],
    ) -> Result<Self, GapError> {
        let without = objective.expect(model, 1)?;
        let candidates = Candidate::missing_from(model, left_out);
        let direction = |candidate: &Candidate| {
            // The first form, with the fewest parameters: its direction is that of the effect.
            let trial = candidate.trials().into_iter().flatten().next();
            trial.map(|trial| direction(objective, model, &without, *candidate, &trial)).transpose()
        };
        let all = candidates.par_iter().map(direction).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { all: all.into_iter().flatten().collect() })
    }

    /// Fraction of a disagreement in the span of the candidates of each domain.
    pub fn shares(&self, deviations: &[f64]) -> BTreeMap<String, f64> {
        // A few huge deviations should not decide a direction.
        let robust = |z: f64| z / (1.0 + z * z / 4.0).sqrt();
        let wanted: Vec<f64> = deviations.iter().map(|z| robust(*z)).collect();
        let whole = dot(&wanted, &wanted);
        let mut bases: BTreeMap<&str, Vec<Vec<f64>>> = BTreeMap::new();
        for direction in &self.all {
            let basis = bases.entry(direction.domain).or_default();
            let mut rest: Vec<f64> = direction.change.iter().map(|z| robust(*z)).collect();
            let length = dot(&rest, &rest);
            // Gram-Schmidt; a small remainder of a direction that others span is noise.
            for known in basis.iter() {
                let along = dot(&rest, known);
                rest.iter_mut().zip(known).for_each(|(rest, known)| *rest -= along * known);
            }
            let left = dot(&rest, &rest);
            if left > MIN_REMAINDER * length && left > 0.0 {
                rest.iter_mut().for_each(|rest| *rest /= left.sqrt());
                basis.push(rest);
            }
        }
        let share = |basis: &[Vec<f64>]| {
            let spanned: f64 = basis.iter().map(|known| dot(&wanted, known).powi(2)).sum();
            if whole > 0.0 { (spanned / whole).min(1.0) } else { 0.0 }
        };
        bases.iter().map(|(domain, basis)| ((*domain).to_owned(), share(basis))).collect()
    }

    /// `|cos|` of the angle between the directions of two candidates.
    pub fn likeness(&self, a: usize, b: usize) -> f64 {
        let (a, b) = (&self.all[a].change, &self.all[b].change);
        let lengths = (dot(a, a) * dot(b, b)).sqrt();
        if lengths > 0.0 { (dot(a, b) / lengths).abs() } else { 0.0 }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Finds the detection limit by bisection on the grid of strengths: the change grows with strength.
fn direction(
    objective: &Objective<'_>,
    model: &SensorConfig,
    without: &Expectation,
    candidate: Candidate,
    trial: &Trial,
) -> Result<Direction, GapError> {
    let head = trial.params[0];
    let mut strengths = trial.strengths();
    match (candidate.spec.signature.strength, head.scale, head.default) {
        (Strength::Falling(_), ..) => strengths.reverse(),
        // On a linear scale, strength is the distance from the neutral value.
        (_, Scale::Linear, Some(none)) => {
            strengths.sort_by(|a, b| (a - none).abs().total_cmp(&(b - none).abs()));
        }
        _ => {}
    }
    let change = |value: f64| -> Result<Vec<f64>, GapError> {
        let with = objective.expect(&trial.with(head, value).added_to(model), 1)?;
        Ok(without.deviations(objective.layout, &with.mean).into_iter().map(clipped).collect())
    };
    let last = strengths.len() - 1;
    let mut high = (last, change(strengths[last])?);
    let is_detectable = |change: &[f64]| discrepancy(change) > DETECTABLE;
    let mut limit = None;
    if is_detectable(&high.1) {
        let mut low = None;
        while low.map_or(high.0 > 0, |low: (usize, f64)| high.0 - low.0 > 1) {
            let middle = low.map_or(high.0 / 2, |low| (low.0 + high.0) / 2);
            let tried = change(strengths[middle])?;
            match is_detectable(&tried) {
                true => high = (middle, tried),
                false => low = Some((middle, discrepancy(&tried))),
            }
        }
        let value = strengths[high.0];
        // Between the two strengths that enclose the limit.
        limit = Some(low.map_or(value, |(below, left)| {
            let share = (DETECTABLE - left) / (discrepancy(&high.1) - left).max(1e-9);
            let below = strengths[below];
            match head.scale {
                Scale::Log if below * value > 0.0 => below * (value / below).powf(share),
                _ => below + (value - below) * share,
            }
        }));
    }
    Ok(Direction {
        name: candidate.name(),
        domain: candidate.spec.domain.name(),
        parameter: head.name,
        unit: head.unit,
        limit,
        strongest: strengths[last],
        change: high.1,
    })
}

/// Clips a deviation: a model with far too many events is infinitely far.
fn clipped(z: f64) -> f64 {
    if z.is_finite() { z.clamp(-MAX_CHANGE, MAX_CHANGE) } else { MAX_CHANGE }
}
