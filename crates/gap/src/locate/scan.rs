//! Scan for the classes in which measured events differ most from those of the model.
//!
//! # Method
//! Kulldorff's scan statistic: the likelihood ratio of the rate in a box against the model's,
//! maximised over boxes, that is over a range on every axis. Coordinate ascent, from several
//! starts. Boxes that are bounded on fewer axes are preferred, because their description is
//! simpler. The same search on each run against the others gives the distribution by chance.
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

/// Starts of the search in addition to the box of all events.
const STARTS: usize = 3;
/// Minimum gain by a bounded axis: a fraction of the score, plus a constant.
const SHARE: f64 = 0.02;
const GAIN: f64 = 3.0;
/// The fraction for the inter-event interval: lost or added events change the intervals of others,
/// so that a range of intervals is reported only where it explains far more than the scene does.
const INTERVAL_SHARE: f64 = 0.6;
const REGIONS: usize = 3;
const LEVEL: f64 = 0.01;
/// Tolerance of the logarithm of a ratio.
const MIN_LOG_RATIO: f64 = 0.02;

/// Regions in which measured events differ most.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Scan {
    /// Description of the first region, or the statement that there is none.
    pub sentence: String,
    /// Significant regions, the most significant first; each beyond what those before it explain.
    pub regions: Vec<Region>,
    /// Best score of each run of the model against the others.
    pub null_scores: Vec<f64>,
}

impl Scan {
    pub(super) fn of_too_few_runs() -> Self {
        let sentence = "Where they differ was not looked for: that takes two runs of the model.";
        Self { sentence: sentence.to_owned(), ..Self::default() }
    }
}

/// Scans the first sample, the recording; the other samples are runs of the model.
pub(super) fn scan(table: &Table, samples: &[Sample], measured: &View<'_>) -> Scan {
    let keys = &table.keys;
    let best = |sample: &Sample| Search { keys, sample }.best();
    // The scores of runs are those that chance gives.
    let (scored, null): (ScoredBox, Vec<ScoredBox>) =
        rayon::join(|| best(&samples[0]), || samples[1..].par_iter().map(best).collect::<Vec<_>>());
    let null_scores: Vec<f64> = null.iter().map(|one| one.score).collect();
    let largest = null_scores.iter().copied().fold(0.0, f64::max);
    let mut sample = samples[0].clone();
    let (mut regions, mut scored) = (Vec::new(), scored);
    while regions.len() < REGIONS {
        let p = chance_of_maximum(scored.score, &null_scores);
        if scored.score <= largest || p > LEVEL {
            break;
        }
        let region = Region::new(scored.levels, (keys, &sample), measured, (scored.score, p));
        // Long recordings make tiny excesses significant.
        if region.ratio.ln().abs() < MIN_LOG_RATIO {
            break;
        }
        // Later regions are beyond what this one explains.
        for (i, _) in keys.iter().enumerate().filter(|(_, key)| *key & !scored.levels == 0) {
            match region.expected > 0.0 && region.measured > 0.0 {
                true => sample.sums[i] *= region.ratio,
                // Nothing can be scaled: these classes are left out.
                false => (sample.events[i], sample.sums[i]) = (0.0, 0.0),
            }
        }
        regions.push(region);
        if regions.len() < REGIONS {
            scored = best(&sample);
        }
    }
    let none = "No part of light, motion, image or time has more or fewer events than runs of the \
                model differ by among themselves.";
    let sentence = regions.first().map_or_else(|| none.to_owned(), |r| r.sentence.clone() + ".");
    Scan { sentence, regions, null_scores }
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct ScoredBox {
    /// Levels of all axes.
    levels: u64,
    score: f64,
    /// Score minus the cost of its bounds.
    worth: f64,
}

struct Search<'a> {
    keys: &'a [u64],
    sample: &'a Sample,
}

impl Search<'_> {
    fn best(&self) -> ScoredBox {
        let all: u64 = Axis::ALL.iter().map(|axis| axis.bits()).sum();
        let everything = self.on(Axis::Brightness, all).into_iter().find(|f| f.levels == all);
        let everything = everything.unwrap_or(ScoredBox { levels: all, score: 0.0, worth: 0.0 });
        let single = |axis: &Axis| best_of(self.on(*axis, all)).unwrap_or(everything);
        let mut starts: Vec<ScoredBox> = Axis::ALL.iter().map(single).collect();
        starts.sort_by(|a, b| b.worth.total_cmp(&a.worth));
        starts.truncate(STARTS);
        // Also from the whole: the best box on a single axis may be a trap.
        starts.push(everything);
        starts.dedup();
        let ends = starts.into_iter().map(|start| self.ascend(start));
        best_of(ends).unwrap_or(everything)
    }

    /// Coordinate ascent over axes.
    fn ascend(&self, mut at: ScoredBox) -> ScoredBox {
        loop {
            let before = at;
            for axis in Axis::ALL {
                let better = best_of(self.on(axis, at.levels));
                // Strictly better, beyond rounding: equal boxes would alternate for ever.
                at = better.filter(|other| other.worth > at.worth + 1e-9).unwrap_or(at);
            }
            if at == before {
                return at;
            }
        }
    }

    /// Boxes with all ranges of one axis, the other axes as in `levels`.
    fn on(&self, axis: Axis, levels: u64) -> Vec<ScoredBox> {
        let outside = !(levels | axis.bits());
        // Classes are summed by level once; each range is then a sum over at most ten levels.
        let mut sums = [Sums::default(); 16];
        for (i, key) in self.keys.iter().enumerate() {
            // A class is in the box unless a level of it lies outside.
            if key & outside == 0 {
                let sums = &mut sums[axis.level(*key)];
                sums.events += self.sample.events[i];
                sums.runs += self.sample.sums[i];
            }
        }
        let rest = levels & !axis.bits();
        let scored = |range: u64| {
            let mut sum = Sums::default();
            for (_, sums) in sums.iter().enumerate().filter(|(level, _)| range >> level & 1 == 1) {
                sum.events += sums.events;
                sum.runs += sums.runs;
            }
            let levels = rest | range << axis.shift();
            let score = sum.score(self.sample.runs);
            ScoredBox { levels, score, worth: worth(levels, score) }
        };
        axis.ranges().into_iter().map(scored).collect()
    }
}

/// Score minus the cost of the bounds of its box.
fn worth(levels: u64, score: f64) -> f64 {
    let is_bound = |axis: &&Axis| levels & axis.bits() != axis.bits();
    Axis::ALL.iter().filter(is_bound).fold(score, |worth, axis| {
        let share = if *axis == Axis::Interval { INTERVAL_SHARE } else { SHARE };
        worth - share * score - GAIN
    })
}

/// The box of the largest worth; among equals the first, so that the result is deterministic.
fn best_of(boxes: impl IntoIterator<Item = ScoredBox>) -> Option<ScoredBox> {
    boxes.into_iter().reduce(|best, next| if next.worth > best.worth { next } else { best })
}
