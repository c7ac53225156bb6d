//! Classifier two-sample test on patches of measured and simulated events.
//!
//! Its features and its method are other than those of the probes: patches that it still separates
//! when all probes agree differ in something that no probe measures.
//!
//! # Method
//! Patches of 20 ms and 32 x 32 pixels are described by 43 features; measured and simulated ones
//! are from the same places and times of one scene. A logistic regression is cross-validated over
//! five folds, grouped by place and time. The statistic is the area under the ROC curve: one half
//! if the patches are indistinguishable. Its null distribution is from permutations that swap the
//! labels of all patches of a tile together, because properties of pixels persist.
//!
//! # Source
//! Lopez-Paz, Oquab: *Revisiting classifier two-sample tests*, ICLR 2017.

mod features;
mod logistic;
mod patches;

use evpose_core::{CounterRng, EventStream, TimeWindow};
use rayon::prelude::*;

use crate::verdict::TwoSample;
use logistic::Data;
use patches::Pair;

/// Label permutations of the null distribution.
const PERMUTATIONS: u64 = 99;
/// Minimum pairs of patches; with fewer, the result is chance.
const MIN_PAIRS: usize = 40;

/// Tests measured against simulated patches of a window. Each tile is compared with the events of
/// one of the simulated streams.
pub fn two_sample(
    measured: &EventStream,
    simulated: &[EventStream],
    window: TimeWindow,
    seed: u64,
) -> TwoSample {
    let pairs = patches::pairs(measured, simulated, window, seed);
    if pairs.len() < MIN_PAIRS {
        return TwoSample { auc: 0.5, p: 1.0 };
    }
    let groups = 1 + pairs.iter().map(|pair| pair.group).max().unwrap_or(0);
    let data = Data::from_pairs(&pairs);
    let auc = data.auc(&labels(&pairs, &vec![false; groups]));
    // Labels are permuted by group: patches of one place and time are not independent.
    let permuted = (0..PERMUTATIONS).into_par_iter().map(|i| {
        let mut rng = CounterRng::new(seed, "exchanged labels", i);
        let swaps: Vec<bool> = (0..groups).map(|_| rng.chance(0.5)).collect();
        data.auc(&labels(&pairs, &swaps))
    });
    let as_large = permuted.filter(|other| *other >= auc).count();
    // The recording counts as one of the permutations.
    TwoSample { auc, p: (1 + as_large) as f64 / (PERMUTATIONS + 1) as f64 }
}

/// Labels of patches: the first of each pair is the measured one, unless its group is swapped.
fn labels(pairs: &[Pair], swaps: &[bool]) -> Vec<bool> {
    pairs.iter().flat_map(|pair| [!swaps[pair.group], swaps[pair.group]]).collect()
}

#[cfg(test)]
mod tests;
