//! Attribution of the disagreement to axes: the fraction that each explains.
//!
//! # Model
//! The difference `d` of measured and expected events of a class is `v` times a sum of effects of
//! its levels, where `v` is the variance of `d` for independent events. Effects are fitted on one
//! half of all classes, in blocks of tile and time, and validated on the other: an axis that
//! explains nothing gains nothing, however many levels it has. Axes of the scene are selected
//! forward; then pairs of the three best, and the inter-event interval. The interval comes last,
//! because any event that is lost or added changes the intervals of others.

use std::collections::BTreeMap;

use evpose_core::stats::linear::solve;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::axis::{Axis, TILES};
use super::table::{Sample, Table, tile};
use super::term::{MAIN, SCENE, Term};

/// Maximum number of runs that are compared with the others, for the gain by chance.
const NULL_RUNS: usize = 4;
/// Minimum gain of a selected axis: in squared standard deviations, and as a fraction of the total.
const MIN_GAIN: f64 = 6.0;
const MIN_SHARE: f64 = 0.01;
/// Number of axes whose pairs are tried.
const PAIRED: usize = 3;
/// Ridge that shrinks effects of levels with few events.
const RIDGE: f64 = 0.5;

/// Fractions of the difference between measured and simulated events that axes explain.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Attribution {
    /// Axes and pairs of axes in the order of selection.
    pub explained: Vec<Explained>,
    /// Total gain on validation data, squared standard deviations.
    pub gain: f64,
    /// Largest total gain of a run of the model against the others.
    pub gain_by_chance: f64,
}

/// Gain of one axis or pair of axes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Explained {
    /// Name; a pair is `a x b`.
    pub axis: String,
    /// Fraction of the total gain.
    pub share: f64,
}

impl Attribution {
    /// Whether the gain is beyond that of runs of the model among themselves.
    pub fn is_significant(&self) -> bool {
        self.gain > 2.0 * self.gain_by_chance + MIN_GAIN
    }

    /// Fractions by name; empty unless the gain is significant.
    pub fn shares(&self) -> BTreeMap<String, f64> {
        let explained = self.explained.iter().filter(|_| self.is_significant());
        explained.map(|one| (one.axis.clone(), one.share)).collect()
    }
}

/// Normal equations of all terms on one half of the classes.
struct Half {
    matrix: Vec<Vec<f64>>,
    right: Vec<f64>,
}

/// Normal equations of both halves.
struct Fit {
    terms: Vec<Term>,
    starts: Vec<usize>,
    halves: [Half; 2],
}

impl Fit {
    fn new(terms: Vec<Term>, keys: &[u64], sample: &Sample) -> Self {
        let mut starts = vec![0];
        for term in &terms {
            starts.push(starts[starts.len() - 1] + term.count());
        }
        let n = starts[terms.len()];
        let half = || Half { matrix: vec![vec![0.0; n]; n], right: vec![0.0; n] };
        let mut halves = [half(), half()];
        let mut columns = vec![0; terms.len()];
        for (i, key) in keys.iter().enumerate() {
            let (events, sums, runs) = (sample.events[i], sample.sums[i], sample.runs);
            let difference = events - sums / runs;
            // Pooled: under the hypothesis of no difference, recording and runs have the same rate.
            let variance = (events + sums) / (runs + 1.0) * (1.0 + 1.0 / runs);
            if variance <= 0.0 {
                continue;
            }
            for (column, (term, start)) in columns.iter_mut().zip(terms.iter().zip(&starts)) {
                *column = start + term.level(*key);
            }
            // A checkerboard over tiles and time: both halves see all of the image and of the
            // window.
            let block = tile(*key) % TILES.0 + tile(*key) / TILES.0 + Axis::Time.level(*key);
            let half = &mut halves[block % 2];
            for (j, a) in columns.iter().enumerate() {
                half.right[*a] += difference;
                for b in &columns[..=j] {
                    half.matrix[*a][*b] += variance;
                }
            }
        }
        Self { terms, starts, halves }
    }

    /// Cross-validated gain of some terms: fitted on one half, validated on the other, and vice
    /// versa.
    fn gain(&self, chosen: &[usize]) -> f64 {
        let columns: Vec<usize> =
            chosen.iter().flat_map(|term| self.starts[*term]..self.starts[*term + 1]).collect();
        let [a, b] = &self.halves;
        [(a, b), (b, a)]
            .map(|(fitted, validated)| validated.gain(&fitted.effects(&columns), &columns))
            .iter()
            .sum()
    }

    /// Forward selection: moves the term with the largest gain from `open` to `chosen` until no
    /// gain is large enough.
    fn select(&self, chosen: &mut Vec<usize>, open: &mut Vec<usize>, gains: &mut Vec<f64>) {
        let mut total = self.gain(chosen);
        loop {
            let with = |term: &usize| {
                let all: Vec<usize> = chosen.iter().copied().chain([*term]).collect();
                self.gain(&all)
            };
            let tried: Vec<(usize, f64)> = open.iter().map(|term| (*term, with(term))).collect();
            // Among equals the first, so that the result is deterministic.
            let Some(best) = tried.into_iter().reduce(|a, b| if b.1 > a.1 { b } else { a }) else {
                return;
            };
            // A gain has to be large by itself, and beside what is explained already.
            if best.1 - total < MIN_GAIN.max(MIN_SHARE * best.1) {
                return;
            }
            gains.push(best.1 - total);
            chosen.push(best.0);
            open.retain(|term| *term != best.0);
            total = best.1;
        }
    }
}

impl Half {
    /// Element of the symmetric matrix, of which only the lower triangle is stored.
    fn at(&self, a: usize, b: usize) -> f64 {
        self.matrix[a.max(b)][a.min(b)]
    }

    fn effects(&self, columns: &[usize]) -> Vec<f64> {
        let matrix = columns
            .iter()
            .map(|a| {
                let ridge = |b: usize| if *a == b { RIDGE } else { 0.0 };
                columns.iter().map(|b| self.at(*a, *b) + ridge(*b)).collect()
            })
            .collect();
        let right = columns.iter().map(|a| self.right[*a]).collect();
        solve(matrix, right).unwrap_or_else(|| vec![0.0; columns.len()])
    }

    fn gain(&self, effects: &[f64], columns: &[usize]) -> f64 {
        let mut gain = 0.0;
        for (a, x) in columns.iter().zip(effects) {
            let row: f64 = columns.iter().zip(effects).map(|(b, y)| self.at(*a, *b) * y).sum();
            gain += x * (2.0 * self.right[*a] - row);
        }
        gain
    }
}

/// Attributes the difference of the first sample, the recording, to axes; the other samples are
/// runs of the model.
pub(super) fn attribute(table: &Table, samples: &[Sample]) -> Attribution {
    let main = |sample: &Sample| {
        let fit = Fit::new(MAIN.to_vec(), &table.keys, sample);
        let (mut chosen, mut gains) = (Vec::new(), Vec::new());
        fit.select(&mut chosen, &mut (0..SCENE).collect(), &mut gains);
        (chosen, gains)
    };
    // Runs of the model explain something of each other by chance, too.
    let null = samples[1..].par_iter().take(NULL_RUNS).map(|sample| main(sample).1);
    let null: Vec<f64> = null.map(|gains| gains.iter().sum()).collect();
    let gain_by_chance = null.into_iter().fold(0.0, f64::max);
    let (mut chosen, mut gains) = main(&samples[0]);
    // Only of the first axes: pairs of all would be too many tests.
    let paired = &chosen[..chosen.len().min(PAIRED)];
    let pairs = paired
        .iter()
        .enumerate()
        .flat_map(|(i, a)| paired[..i].iter().map(|b| Term::Pair(*a.min(b), *a.max(b))));
    // The age determines where the speed is zero, and the level is constant: those are no pairs.
    let is_crossed = |pair: &Term| *pair != Term::Pair(2, 3) && !matches!(pair, Term::Pair(0, _));
    let terms: Vec<Term> = MAIN.into_iter().chain(pairs.filter(is_crossed)).collect();
    let fit = Fit::new(terms, &table.keys, &samples[0]);
    fit.select(&mut chosen, &mut (SCENE..fit.terms.len()).collect(), &mut gains);
    let gain = gains.iter().fold(0.0, |sum, gain| sum + gain);
    let explained = chosen
        .iter()
        .zip(&gains)
        .map(|(term, own)| Explained { axis: fit.terms[*term].name(), share: own / gain });
    Attribution { explained: explained.collect(), gain, gain_by_chance }
}
