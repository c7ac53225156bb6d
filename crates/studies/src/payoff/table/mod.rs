//! Scores of networks on the same recordings, and their paired differences.
//!
//! # Model
//! A score is pooled over recordings: the mean of all values, or of each joint's mean. A resample
//! draws recordings with replacement, and the same ones for every network, so that the difficulty
//! of a recording cancels in a difference. Values of several seeds are pooled; the difference under
//! each seed is listed beside, because the interval knows of recordings alone.
//!
//! # Source
//! [`evpose_core::stats::bootstrap`]: the percentile bootstrap over whole recordings.

use std::collections::BTreeMap;

use anyhow::{Result, ensure};
use evpose_cli::tasks::{EvaluationScores, Metric};
use evpose_core::stats::bootstrap::{BootstrapConfig, Totals, bootstrap};
use evpose_core::stats::interval::Interval;
use serde::Serialize;

/// Scores of the networks that were trained on one model, one for each seed.
#[derive(Debug, Clone)]
pub struct ModelScores {
    /// Name of the model.
    pub model: &'static str,
    /// Scores under each seed, in the order of the seeds.
    pub by_seed: Vec<EvaluationScores>,
}

/// The table of a study: a row for each metric.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairedTable {
    /// Number of recordings.
    pub recordings: usize,
    /// Metrics, the main one first.
    pub rows: Vec<MetricRow>,
}

/// One metric.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MetricRow {
    /// The metric.
    #[serde(flatten)]
    pub metric: Metric,
    /// Score of each model by its name. None where nothing was measured.
    pub scores: BTreeMap<&'static str, Option<Interval>>,
    /// The second model less the first. None where nothing was measured.
    pub difference: Option<Interval>,
    /// The same under each seed alone.
    pub difference_by_seed: Vec<Option<f64>>,
    /// The same on each recording, in their order.
    pub difference_by_recording: Vec<Option<f64>>,
    /// The difference over that of the third model, if there is one and its own interval excludes
    /// zero: the fraction of what can be gained.
    pub fraction_of_upper_bound: Option<Interval>,
}

/// Meaning of a difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Worth {
    /// The interval lies on the better side of zero.
    Better,
    /// The interval lies on the worse side of zero.
    Worse,
    /// The interval holds zero, or there is none.
    Undecided,
}

impl MetricRow {
    /// Whether the second model is better than the first.
    pub fn worth(&self) -> Worth {
        let Some(Interval { low: Some(low), high: Some(high), .. }) = self.difference else {
            return Worth::Undecided;
        };
        let (is_up, is_down) = (low > 0.0, high < 0.0);
        match (is_up, is_down, self.metric.is_error) {
            (true, _, false) | (_, true, true) => Worth::Better,
            (true, _, true) | (_, true, false) => Worth::Worse,
            _ => Worth::Undecided,
        }
    }
}

impl PairedTable {
    /// The table of models whose networks were evaluated on the same recordings: the model as given
    /// first, the corrected one second, an upper bound third.
    ///
    /// # Errors
    /// If there are fewer than two models, or they were evaluated on other recordings or seeds.
    pub fn new(models: &[ModelScores], config: &BootstrapConfig) -> Result<Self> {
        ensure!(models.len() >= 2, "a comparison takes two models");
        let first = models[0].by_seed.first();
        let first = first.ok_or_else(|| anyhow::anyhow!("no seed was evaluated"))?;
        let names = |scores: &EvaluationScores| -> Vec<String> {
            scores.recordings.iter().map(|recording| recording.recording.clone()).collect()
        };
        // Differences are paired: recordings have to agree in their order, too.
        for model in models {
            ensure!(
                model.by_seed.len() == models[0].by_seed.len()
                    && model.by_seed.iter().all(|scores| names(scores) == names(first)),
                "{} was evaluated on other recordings or seeds than {}",
                model.model,
                models[0].model
            );
        }
        let rows = (0..first.metrics.len()).map(|metric| row(models, metric, config)).collect();
        Ok(Self { recordings: first.recordings.len(), rows })
    }
}

fn row(models: &[ModelScores], metric: usize, config: &BootstrapConfig) -> MetricRow {
    let seeds = models[0].by_seed.len();
    let of = |model: &ModelScores, seeds: std::ops::Range<usize>| -> Vec<Vec<Totals>> {
        let count = model.by_seed[0].recordings.len();
        let values = |recording: usize| {
            let scores = model.by_seed[seeds.clone()].iter();
            add(scores.map(|scores| &scores.recordings[recording].totals[metric]))
        };
        (0..count).map(values).collect()
    };
    let pooled: Vec<Vec<Vec<Totals>>> = models.iter().map(|model| of(model, 0..seeds)).collect();
    // Recordings on which a network has no value, because it found nothing, have no pair.
    let has_pairs =
        |recording: &usize| pooled.iter().all(|model| value(model, &[*recording]).is_some());
    let paired: Vec<usize> = (0..pooled[0].len()).filter(has_pairs).collect();
    let interval = |statistic: &dyn Fn(&[usize]) -> Option<f64>| {
        (!paired.is_empty()).then(|| {
            // Recordings are drawn, not poses: those of one recording are alike.
            bootstrap(paired.len(), config, |drawn| {
                let drawn: Vec<usize> = drawn.iter().map(|&i| paired[i]).collect();
                statistic(&drawn).unwrap_or(f64::NAN)
            })
        })
    };
    let less = |a: usize, b: usize, drawn: &[usize]| {
        Some(value(&pooled[a], drawn)? - value(&pooled[b], drawn)?)
    };
    let scores = models.iter().zip(&pooled);
    let scores =
        scores.map(|(model, values)| (model.model, interval(&|drawn| value(values, drawn))));
    let by_seed = |seed: usize| {
        let [given, corrected] = [0, 1].map(|model| of(&models[model], seed..seed + 1));
        Some(value(&corrected, &paired)? - value(&given, &paired)?)
    };
    let is_measurable = |interval: Option<Interval>| {
        interval.is_some_and(|interval| {
            interval.low.zip(interval.high).is_some_and(|(low, high)| low > 0.0 || high < 0.0)
        })
    };
    // Unless the interval of the bound excludes zero, a fraction of it means nothing.
    let has_bound = pooled.len() > 2 && is_measurable(interval(&|drawn| less(2, 0, drawn)));
    MetricRow {
        metric: models[0].by_seed[0].metrics[metric],
        scores: scores.collect(),
        difference: interval(&|drawn| less(1, 0, drawn)),
        difference_by_seed: (0..seeds).map(by_seed).collect(),
        difference_by_recording: (0..pooled[0].len()).map(|i| less(1, 0, &[i])).collect(),
        fraction_of_upper_bound: has_bound
            .then(|| interval(&|drawn| Some(less(1, 0, drawn)? / less(2, 0, drawn)?)))
            .flatten(),
    }
}

/// The pooled score of recordings: the mean over joints of each joint's mean.
fn value(recordings: &[Vec<Totals>], drawn: &[usize]) -> Option<f64> {
    let joints = add(drawn.iter().map(|&i| &recordings[i]));
    let mut mean = Totals::default();
    joints.into_iter().filter_map(Totals::mean).for_each(|value| mean.push(value));
    mean.mean()
}

/// Sums joint by joint.
fn add<'a>(parts: impl Iterator<Item = &'a Vec<Totals>>) -> Vec<Totals> {
    let mut all: Vec<Totals> = Vec::new();
    for part in parts {
        all.resize(all.len().max(part.len()), Totals::default());
        for (sum, more) in all.iter_mut().zip(part) {
            *sum = [*sum, *more].into_iter().sum();
        }
    }
    all
}

#[cfg(test)]
mod tests;
