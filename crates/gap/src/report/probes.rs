//! All compared statistics, and gaps of their blocks.

use evpose_core::stats::quantile::nearest_index;
use serde::{Deserialize, Serialize};

use crate::compare::by_block;
use crate::entry::StatisticKind;
use crate::verdict::GapValue;
use crate::{Expectation, Layout, StatisticBlock, rho_of_chance};

/// Gap of one block of statistics.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BlockGap {
    /// Family of statistics.
    pub block: StatisticBlock,
    /// Gap of the model as given.
    pub before: GapValue,
    /// Gap of the corrected model.
    pub after: GapValue,
}

/// One compared statistic.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProbeRow {
    /// Family of statistics that it belongs to.
    pub block: StatisticBlock,
    /// Name.
    pub name: String,
    /// Deviation from the model as given, standard deviations.
    pub before: f64,
    /// Deviation from the corrected model, standard deviations.
    pub after: f64,
    /// Measured over expected minus one, for counts.
    pub relative: Option<f64>,
}

/// Gaps of blocks, from the deviations of the model as given and of the corrected one.
///
/// `resampled` are pairs of deviations from bootstrap resamples, for 90 % intervals.
pub fn block_gaps(
    layout: &Layout,
    (before, after): (&[f64], &[f64]),
    resampled: &[(Vec<f64>, Vec<f64>)],
) -> Vec<BlockGap> {
    let chance = rho_of_chance();
    let gaps = |deviations: &[f64]| -> Vec<(StatisticBlock, f64)> {
        let blocks = by_block(layout, deviations);
        blocks.into_iter().map(|(block, distance)| (block, distance / chance)).collect()
    };
    let of_before: Vec<_> = resampled.iter().map(|(before, _)| gaps(before)).collect();
    let of_after: Vec<_> = resampled.iter().map(|(_, after)| gaps(after)).collect();
    let value = |value: f64, block: usize, of: &[Vec<(StatisticBlock, f64)>]| {
        let mut values: Vec<f64> = of.iter().map(|gaps| gaps[block].1).collect();
        values.sort_by(f64::total_cmp);
        let at =
            |share: f64| values.get(nearest_index(values.len(), share)).copied().unwrap_or(value);
        // Resampling biases a distance upwards: the interval is extended to hold the value itself.
        GapValue { value, lo: at(0.05).min(value), hi: at(0.95).max(value) }
    };
    let after = gaps(after);
    let rows = gaps(before).into_iter().zip(after).enumerate();
    rows.map(|(i, ((block, before), (_, after)))| BlockGap {
        block,
        before: value(before, i, &of_before),
        after: value(after, i, &of_after),
    })
    .collect()
}

/// All statistics of a summary against two expectations, the largest deviation first, without those
/// undefined on both sides.
pub fn probe_rows(
    layout: &Layout,
    measured: &[f64],
    before: &Expectation,
    after: &Expectation,
) -> Vec<ProbeRow> {
    let (z_before, z_after) =
        (before.deviations(layout, measured), after.deviations(layout, measured));
    let mut rows: Vec<ProbeRow> = layout
        .entries
        .iter()
        .enumerate()
        .filter(|(i, _)| z_before[*i] != 0.0 || z_after[*i] != 0.0)
        .map(|(i, entry)| {
            // Counts are compared as `2 sqrt(n + 3/8)`.
            let count = |value: f64| value * value / 4.0 - 0.375;
            let relative = match entry.kind {
                StatisticKind::Count(..)
                    if before.mean[i].is_finite() && measured[i].is_finite() =>
                {
                    let expected = count(before.mean[i]);
                    (expected >= 0.5).then(|| count(measured[i]) / expected - 1.0)
                }
                _ => None,
            };
            ProbeRow {
                block: entry.block,
                name: entry.name.clone(),
                before: z_before[i],
                after: z_after[i],
                relative,
            }
        })
        .collect();
    rows.sort_by(|a, b| b.before.abs().total_cmp(&a.before.abs()));
    rows
}
