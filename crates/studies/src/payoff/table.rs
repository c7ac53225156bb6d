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

use crate::study::{Relation, Verdict, verdict};

/// Scores of the networks that were trained on one model, one for each seed.
#[derive(Debug, Clone)]
pub(crate) struct ModelScores {
    pub(crate) model: &'static str,
    /// Scores under each seed, in the order of the seeds.
    pub(crate) by_seed: Vec<EvaluationScores>,
}

/// The table of a study: a row for each metric.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct PairedTable {
    pub(crate) recordings: usize,
    /// Metrics, the main one first.
    pub(crate) rows: Vec<MetricRow>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct MetricRow {
    #[serde(flatten)]
    pub(crate) metric: Metric,
    /// Score of each model by its name. None where nothing was measured.
    pub(crate) scores: BTreeMap<&'static str, Option<Interval>>,
    /// The second model less the first. None where nothing was measured.
    pub(crate) difference: Option<Interval>,
    /// The same under each seed alone.
    pub(crate) difference_by_seed: Vec<Option<f64>>,
    /// The same on each recording, in their order.
    pub(crate) difference_by_recording: Vec<Option<f64>>,
    /// The difference over that of the third model, if there is one and its own interval excludes
    /// zero: the fraction of what can be gained.
    pub(crate) fraction_of_upper_bound: Option<Interval>,
}

impl MetricRow {
    /// Whether the second model trains a worse network; reversed if a better one.
    pub(crate) fn is_worse(&self) -> Option<Verdict> {
        self.difference.as_ref().map(|difference| verdict(Relation::Worse, self.metric, difference))
    }
}

impl PairedTable {
    /// The table of models whose networks were evaluated on the same recordings: the model as given
    /// first, the corrected one second, an upper bound third.
    pub(crate) fn new(models: &[ModelScores], config: &BootstrapConfig) -> Result<Self> {
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
            // Both differences are of one resample, so that their common errors cancel.
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
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use evpose_cli::tasks::RecordingScores;
    use evpose_core::CounterRng;

    use super::*;

    const QUICK: BootstrapConfig = BootstrapConfig { resamples: 500, seed: 1 };

    const METRICS: [Metric; 2] = [
        Metric { key: "auc", heading: "AUC", digits: 3, is_error: false },
        Metric { key: "mpjpe", heading: "MPJPE", digits: 1, is_error: true },
    ];

    /// Scores of recordings, each of its own difficulty: the value of recording `i` is its difficulty
    /// plus `gain(i)`.
    fn scores(count: usize, gain: impl Fn(usize) -> f64) -> EvaluationScores {
        let recording = |i: usize| {
            let difficulty = f64::from(CounterRng::new(7, "difficulty", i as u64).normal());
            let value = 10.0 + difficulty + gain(i);
            let totals = vec![Totals { sum: 100.0 * value, count: 100 }];
            RecordingScores { recording: format!("{i:04}"), totals: vec![totals; METRICS.len()] }
        };
        EvaluationScores { metrics: &METRICS, recordings: (0..count).map(recording).collect() }
    }

    fn model(model: &'static str, by_seed: Vec<EvaluationScores>) -> ModelScores {
        ModelScores { model, by_seed }
    }

    fn table(models: &[ModelScores]) -> PairedTable {
        PairedTable::new(models, &QUICK).unwrap()
    }

    fn bounds(interval: Option<Interval>) -> [f64; 3] {
        let interval = interval.unwrap();
        [interval.estimate, interval.low.unwrap(), interval.high.unwrap()]
    }

    #[test]
    fn the_difficulty_of_a_recording_cancels_in_the_difference() {
        let models = [
            model("given", vec![scores(20, |_| 0.0)]),
            model("corrected", vec![scores(20, |_| 0.5)]),
        ];
        let table = table(&models);
        assert_eq!((table.recordings, table.rows.len()), (20, 2));
        let row = &table.rows[0];
        assert!(
            bounds(row.difference).iter().all(|d| (d - 0.5).abs() < 1e-9),
            "{:?}",
            row.difference
        );
        assert!(row.difference_by_recording.iter().all(|d| (d.unwrap() - 0.5).abs() < 1e-9));
        // The scores themselves are uncertain, as recordings differ.
        let [_, low, high] = bounds(row.scores["given"]);
        assert!(high - low > 0.4, "{low} {high}");
        // More is better of a share, and worse of an error.
        assert_eq!(table.rows[0].is_worse(), Some(Verdict::Reversed));
        assert_eq!(table.rows[1].is_worse(), Some(Verdict::Found));
    }

    #[test]
    fn a_difference_that_changes_sign_among_recordings_is_undecided() {
        let noise = |i: usize| f64::from(CounterRng::new(3, "gain", i as u64).normal());
        let models = [
            model("given", vec![scores(20, |_| 0.0)]),
            model("corrected", vec![scores(20, noise)]),
        ];
        let [estimate, low, high] = bounds(table(&models).rows[0].difference);
        assert!(low < 0.0 && 0.0 < high && low < estimate && estimate < high, "{low} {high}");
        assert_eq!(table(&models).rows[0].is_worse(), Some(Verdict::WithinNoise));
        // One recording has a difference without an interval.
        let alone = table(&[
            model("given", vec![scores(1, |_| 0.0)]),
            model("corrected", vec![scores(1, |_| 1.0)]),
        ]);
        assert_eq!(alone.rows[0].difference.unwrap().low, None);
        assert_eq!(alone.rows[0].is_worse(), Some(Verdict::OneSeed));
    }

    #[test]
    fn seeds_are_pooled_and_listed() {
        let by_seed = |gains: [f64; 2]| gains.map(|gain| scores(12, |_| gain)).to_vec();
        let models = [model("given", by_seed([0.0, 0.2])), model("corrected", by_seed([1.0, 0.4]))];
        let row = table(&models).rows[0].clone();
        assert!((row.difference.unwrap().estimate - 0.6).abs() < 1e-9, "{row:?}");
        let [first, second] = row.difference_by_seed[..] else { panic!("{row:?}") };
        assert!((first.unwrap() - 1.0).abs() < 1e-9 && (second.unwrap() - 0.2).abs() < 1e-9);
    }

    #[test]
    fn an_upper_bound_gives_a_fraction_where_there_is_something_to_gain() {
        let of = |corrected: f64, camera: f64| {
            let row = table(&[
                model("given", vec![scores(16, |_| 0.0)]),
                model("corrected", vec![scores(16, |_| corrected)]),
                model("camera", vec![scores(16, |_| camera)]),
            ]);
            row.rows[0].fraction_of_upper_bound
        };
        assert!(bounds(of(0.6, 0.8)).iter().all(|fraction| (fraction - 0.75).abs() < 1e-9));
        assert_eq!(of(0.0, 0.0), None);
    }

    #[test]
    fn joints_weigh_alike_and_recordings_without_a_value_have_no_pair() {
        let of = |joints: [[(f64, u64); 2]; 2]| {
            let totals = |(mean, count): (f64, u64)| Totals { sum: mean * count as f64, count };
            let recording = |(i, joints): (usize, [(f64, u64); 2])| RecordingScores {
                recording: i.to_string(),
                totals: vec![joints.map(totals).to_vec(); METRICS.len()],
            };
            let recordings = joints.into_iter().enumerate().map(recording).collect();
            EvaluationScores { metrics: &METRICS, recordings }
        };
        // The second joint is labelled ten times as often, and counts the same.
        let given = of([[(1.0, 10), (3.0, 100)], [(1.0, 10), (3.0, 100)]]);
        let corrected = of([[(2.0, 10), (3.0, 100)], [(2.0, 10), (3.0, 100)]]);
        let row =
            table(&[model("given", vec![given.clone()]), model("corrected", vec![corrected])]).rows
                [0]
            .clone();
        assert!((row.scores["given"].unwrap().estimate - 2.0).abs() < 1e-12);
        assert!((row.difference.unwrap().estimate - 0.5).abs() < 1e-12);
        // Nothing was found on the second recording.
        let blind = of([[(2.0, 10), (3.0, 100)], [(0.0, 0), (0.0, 0)]]);
        let row =
            table(&[model("given", vec![given]), model("corrected", vec![blind])]).rows[0].clone();
        assert_eq!(row.difference_by_recording[1], None);
        assert!((row.difference.unwrap().estimate - 0.5).abs() < 1e-12);
    }

    #[test]
    fn networks_of_other_recordings_are_not_compared() {
        let pair = |other: usize| {
            [
                model("given", vec![scores(4, |_| 0.0)]),
                model("corrected", vec![scores(other, |_| 0.0)]),
            ]
        };
        let error = PairedTable::new(&pair(5), &QUICK).unwrap_err().to_string();
        assert!(error.contains("other recordings"), "{error}");
        assert!(PairedTable::new(&pair(4)[..1], &QUICK).is_err());
    }
}
