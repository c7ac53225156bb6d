//! The part of all classes in which measured events differ most from those of the model.
//!
//! # Method
//! Kulldorff's scan: the likelihood ratio of one rate in a box against the model's, maximised over
//! boxes, that is over a range on every axis. One axis is improved at a time, from several starts,
//! until none improves it. A box that is bound on fewer axes is preferred, because it is easier to
//! say. The same search on each run against the others gives what chance makes of it.
//!
//! # Source
//! Kulldorff: *A spatial scan statistic*, Communications in Statistics 26, 1997.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::axis::Axis;
use super::region::{Region, Sums};
use super::significance::chance_of_maximum;
use super::table::{Sample, Table};
use crate::View;

/// Starts of the search beside that of all events.
const STARTS: usize = 3;
/// What binding an axis must gain: a share of the score, and beyond that.
const SHARE: f64 = 0.02;
const GAIN: f64 = 3.0;
/// The share for the pause of a pixel: losing or adding any events changes the pauses between the
/// others, so that pauses are told only where they say far more than what the scene does.
const PAUSE_SHARE: f64 = 0.6;
/// Regions that are told at most.
const REGIONS: usize = 3;
/// What is called significant.
const LEVEL: f64 = 0.01;
/// Ratios nearer to one do not matter.
const LEAST_LOG_RATIO: f64 = 0.02;

/// The regions in which measured events differ most.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Scan {
    /// The first of them in words, or that there is none.
    pub sentence: String,
    /// Those that are significant, the most significant first; each beyond what those before it
    /// explain.
    pub regions: Vec<Region>,
    /// The score that each run of the model reaches against the others.
    pub null_scores: Vec<f64>,
}

impl Scan {
    pub(super) fn of_too_few_runs() -> Self {
        let sentence = "Where they differ was not looked for: that takes two runs of the model.";
        Self { sentence: sentence.to_owned(), ..Self::default() }
    }
}

pub(super) fn scan(table: &Table, samples: &[Sample], measured: &View<'_>) -> Scan {
    let keys = &table.keys;
    let best = |sample: &Sample| Search { keys, sample }.best();
    let (found, null): (Found, Vec<Found>) =
        rayon::join(|| best(&samples[0]), || samples[1..].par_iter().map(best).collect::<Vec<_>>());
    let null_scores: Vec<f64> = null.iter().map(|found| found.score).collect();
    let largest = null_scores.iter().copied().fold(0.0, f64::max);
    let mut sample = samples[0].clone();
    let (mut regions, mut found) = (Vec::new(), found);
    while regions.len() < REGIONS {
        let p = chance_of_maximum(found.score, &null_scores);
        if found.score <= largest || p > LEVEL {
            break;
        }
        let region = Region::of(found.levels, (keys, &sample), measured, (found.score, p));
        if region.ratio.ln().abs() < LEAST_LOG_RATIO {
            break;
        }
        // What the region explains is no disagreement any more.
        for (i, _) in keys.iter().enumerate().filter(|(_, key)| *key & !found.levels == 0) {
            match region.expected > 0.0 && region.measured > 0.0 {
                true => sample.sums[i] *= region.ratio,
                false => (sample.events[i], sample.sums[i]) = (0.0, 0.0),
            }
        }
        regions.push(region);
        if regions.len() < REGIONS {
            found = best(&sample);
        }
    }
    let none = "No part of light, motion, image or time has more or fewer events than runs of the \
                model differ by among themselves.";
    let sentence = regions.first().map_or_else(|| none.to_owned(), |r| r.sentence.clone() + ".");
    Scan { sentence, regions, null_scores }
}

/// A box and its score.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Found {
    /// Allowed levels of all axes.
    levels: u64,
    score: f64,
    /// The score less what its bounds cost.
    worth: f64,
}

struct Search<'a> {
    keys: &'a [u64],
    sample: &'a Sample,
}

impl Search<'_> {
    fn best(&self) -> Found {
        let all: u64 = Axis::ALL.iter().map(|axis| axis.bits()).sum();
        let everything = self.on(Axis::Brightness, all).into_iter().find(|f| f.levels == all);
        let everything = everything.unwrap_or(Found { levels: all, score: 0.0, worth: 0.0 });
        let single = |axis: &Axis| best_of(self.on(*axis, all)).unwrap_or(everything);
        let mut starts: Vec<Found> = Axis::ALL.iter().map(single).collect();
        starts.sort_by(|a, b| b.worth.total_cmp(&a.worth));
        starts.truncate(STARTS);
        starts.push(everything);
        starts.dedup();
        let ends = starts.into_iter().map(|start| self.ascend(start));
        best_of(ends).unwrap_or(everything)
    }

    /// Improves one axis after the other until that improves nothing.
    fn ascend(&self, mut at: Found) -> Found {
        loop {
            let before = at;
            for axis in Axis::ALL {
                let better = best_of(self.on(axis, at.levels));
                at = better.filter(|found| found.worth > at.worth + 1e-9).unwrap_or(at);
            }
            if at == before {
                return at;
            }
        }
    }

    /// All ranges of one axis, the others as in `levels`.
    fn on(&self, axis: Axis, levels: u64) -> Vec<Found> {
        let outside = !(levels | axis.bits());
        let mut sums = [Sums::default(); 16];
        for (i, key) in self.keys.iter().enumerate() {
            if key & outside == 0 {
                let sums = &mut sums[axis.level(*key)];
                sums.events += self.sample.events[i];
                sums.runs += self.sample.sums[i];
            }
        }
        let rest = levels & !axis.bits();
        let found = |range: u64| {
            let mut sum = Sums::default();
            for (level, sums) in sums.iter().enumerate().filter(|(l, _)| range >> l & 1 == 1) {
                debug_assert!(level < axis.count());
                sum.events += sums.events;
                sum.runs += sums.runs;
            }
            let levels = rest | range << axis.shift();
            let score = sum.score(self.sample.runs);
            Found { levels, score, worth: worth(levels, score) }
        };
        axis.ranges().into_iter().map(found).collect()
    }
}

/// A score less what the bounds of its box cost.
fn worth(levels: u64, score: f64) -> f64 {
    let is_bound = |axis: &&Axis| levels & axis.bits() != axis.bits();
    Axis::ALL.iter().filter(is_bound).fold(score, |worth, axis| {
        let share = if *axis == Axis::Pause { PAUSE_SHARE } else { SHARE };
        worth - share * score - GAIN
    })
}

fn best_of(found: impl IntoIterator<Item = Found>) -> Option<Found> {
    // Of equals the first, whatever the order of sums.
    found.into_iter().reduce(|best, next| if next.worth > best.worth { next } else { best })
}
