//! What every effect does to the numbers that are compared: by how much it must be there to show,
//! and which effects look alike.
//!
//! # Method
//! The first part of the recording is simulated with each candidate beside the model, at the least
//! of its strengths that shows; the difference to the model alone, in standard deviations, is its
//! direction. How much of a disagreement the directions of one domain of the camera span says how
//! near it is to that domain.

use std::collections::BTreeMap;

use evpose_sensor::{Scale, SensorConfig, Strength};
use rayon::prelude::*;

use crate::candidate::{Candidate, Trial};
use crate::compare::Expectation;
use crate::{GapError, Lab, misfit};

/// A misfit that shows.
const SHOWS: f64 = 60.0;

/// One candidate beside a model.
#[derive(Debug, Clone)]
pub struct Direction {
    /// The name in the catalogue.
    pub name: &'static str,
    /// The domain of the camera.
    pub domain: &'static str,
    /// The number that makes it strong.
    pub parameter: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The least value that shows; none if none of those tried does.
    pub limit: Option<f64>,
    /// The strongest value that was tried.
    pub strongest: f64,
    /// Differences to the model, in standard deviations, where it shows or is strongest.
    pub change: Vec<f64>,
}

/// All candidates beside a model.
#[derive(Debug, Clone)]
pub struct Directions {
    /// In the order of the catalogue.
    pub all: Vec<Direction>,
}

impl Directions {
    /// Tries every candidate beside a model.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn of(lab: &Lab<'_>, model: &SensorConfig, left_out: &[String]) -> Result<Self, GapError> {
        let without = lab.expect(model, 1)?;
        let candidates = Candidate::beside(model, left_out);
        let direction = |candidate: &Candidate| {
            let trial = candidate.trials().into_iter().flatten().next();
            trial.map(|trial| direction(lab, model, &without, *candidate, &trial)).transpose()
        };
        let all = candidates.par_iter().map(direction).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { all: all.into_iter().flatten().collect() })
    }

    /// The share of a disagreement that the candidates of each domain span.
    pub fn shares(&self, deviations: &[f64]) -> BTreeMap<String, f64> {
        let robust = |z: f64| z / (1.0 + z * z / 4.0).sqrt();
        let wanted: Vec<f64> = deviations.iter().map(|z| robust(*z)).collect();
        let whole = dot(&wanted, &wanted);
        let mut bases: BTreeMap<&str, Vec<Vec<f64>>> = BTreeMap::new();
        for direction in &self.all {
            let basis = bases.entry(direction.domain).or_default();
            let mut rest: Vec<f64> = direction.change.iter().map(|z| robust(*z)).collect();
            let length = dot(&rest, &rest);
            // Gram and Schmidt; what is left of a direction that others span is noise.
            for known in basis.iter() {
                let along = dot(&rest, known);
                rest.iter_mut().zip(known).for_each(|(rest, known)| *rest -= along * known);
            }
            let left = dot(&rest, &rest);
            if left > 1e-3 * length && left > 0.0 {
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

    /// `|cos|` of the angle between what two candidates do.
    pub fn likeness(&self, a: usize, b: usize) -> f64 {
        let (a, b) = (&self.all[a].change, &self.all[b].change);
        let lengths = (dot(a, a) * dot(b, b)).sqrt();
        if lengths > 0.0 { (dot(a, b) / lengths).abs() } else { 0.0 }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Finds the least strength that shows, by halving: what an effect does grows with its strength.
fn direction(
    lab: &Lab<'_>,
    model: &SensorConfig,
    without: &Expectation,
    candidate: Candidate,
    trial: &Trial,
) -> Result<Direction, GapError> {
    let head = trial.params[0];
    let mut strengths = trial.strengths();
    match (candidate.spec.signature.strength, head.scale, head.neutral) {
        (Strength::Falling(_), ..) => strengths.reverse(),
        // What goes either way is the stronger, the further it is from doing nothing.
        (_, Scale::Linear, Some(none)) => {
            strengths.sort_by(|a, b| (a - none).abs().total_cmp(&(b - none).abs()));
        }
        _ => {}
    }
    let change = |value: f64| -> Result<Vec<f64>, GapError> {
        let with = lab.expect(&trial.with(head, value).beside(model), 1)?;
        Ok(without.deviations(lab.layout, &with.mean).into_iter().map(bounded).collect())
    };
    let last = strengths.len() - 1;
    let mut high = (last, change(strengths[last])?);
    let shows = |change: &[f64]| misfit(change) > SHOWS;
    let mut limit = None;
    if shows(&high.1) {
        let mut low = None;
        while low.map_or(high.0 > 0, |low: (usize, f64)| high.0 - low.0 > 1) {
            let middle = low.map_or(high.0 / 2, |low| (low.0 + high.0) / 2);
            let tried = change(strengths[middle])?;
            match shows(&tried) {
                true => high = (middle, tried),
                false => low = Some((middle, misfit(&tried))),
            }
        }
        let value = strengths[high.0];
        limit = Some(low.map_or(value, |(below, left)| {
            let share = (SHOWS - left) / (misfit(&high.1) - left).max(1e-9);
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

/// A model with far too many events is no direction.
fn bounded(z: f64) -> f64 {
    if z.is_finite() { z.clamp(-100.0, 100.0) } else { 100.0 }
}
