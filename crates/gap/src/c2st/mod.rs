//! Whether a classifier tells patches of measured events from patches of simulated ones.
//!
//! It looks at other things than the probes do, and in another way: what it still tells apart when
//! all probes agree is something that nobody thought of.
//!
//! # Method
//! Classifier two-sample test: patches of 20 ms and 32 x 32 pixels, each as about forty numbers,
//! measured and simulated ones from the same places and times of one scene. A logistic regression
//! is trained on four fifths of them, grouped by place and time, and judged on the rest; the area
//! under its curve is one half if nothing tells them apart. How large it is by chance comes from
//! labels that are exchanged for all patches of a tile together, because what a pixel is like stays.
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

/// Exchanges of labels that chance is judged by.
const EXCHANGES: u64 = 99;
/// With fewer pairs nothing can be told.
const LEAST_PAIRS: usize = 40;

/// Tells measured from simulated patches of a window. Each tile is compared with the events of one
/// of the simulated streams.
pub fn two_sample(
    measured: &EventStream,
    simulated: &[EventStream],
    window: TimeWindow,
    seed: u64,
) -> TwoSample {
    let pairs = patches::pairs(measured, simulated, window, seed);
    if pairs.len() < LEAST_PAIRS {
        return TwoSample { auc: 0.5, p: 1.0 };
    }
    let groups = 1 + pairs.iter().map(|pair| pair.group).max().unwrap_or(0);
    let data = Data::of(&pairs);
    let auc = data.auc(&labels(&pairs, &vec![false; groups]));
    let exchanged = (0..EXCHANGES).into_par_iter().map(|i| {
        let mut rng = CounterRng::new(seed, "exchanged labels", i);
        let swaps: Vec<bool> = (0..groups).map(|_| rng.chance(0.5)).collect();
        data.auc(&labels(&pairs, &swaps))
    });
    let as_large = exchanged.filter(|other| *other >= auc).count();
    TwoSample { auc, p: (1 + as_large) as f64 / (EXCHANGES + 1) as f64 }
}

/// Whether each patch counts as measured: of a pair the first, unless its group is exchanged.
fn labels(pairs: &[Pair], swaps: &[bool]) -> Vec<bool> {
    pairs.iter().flat_map(|pair| [!swaps[pair.group], swaps[pair.group]]).collect()
}

#[cfg(test)]
mod tests;
