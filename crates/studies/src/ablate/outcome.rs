//! Means of all rows over seeds, with intervals, and published findings compared with them.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use evpose_core::stats::interval::{Interval, t_interval};
use serde::Serialize;

use super::finding::{Finding, Relation, Verdict};
use super::rows::{FULL, Row};
use super::trial::{Metrics, Provenance, Scores, Trial};
use crate::study::mean_curve;

/// The trials of every trained row, by its name, in the order of the seeds.
pub(super) type Trials = BTreeMap<&'static str, Vec<Trial>>;

/// A metric of a method by its name.
type Metric = (&'static str, fn(&Metrics) -> f64);

const METRICS: [Metric; 6] = [
    ("auc_2d", |f| f.auc_2d),
    ("auc_3d", |f| f.auc_3d),
    ("mpjpe_mm", |f| f.mpjpe_mm),
    ("translation_mm", |f| f.translation_mm),
    ("rotation_deg", |f| f.rotation_deg),
    ("articulation", |f| f.articulation),
];

/// Content of `ablation.json`.
#[derive(Debug, Serialize)]
pub(super) struct Outcome {
    /// Name or file of the config of all rows.
    pub(super) config: String,
    pub(super) seeds: Vec<u64>,
    /// Milliseconds between evaluated poses.
    pub(super) stride_ms: u32,
    /// Programs and machines of the trials: more than one if the study was continued elsewhere.
    pub(super) made: Vec<Provenance>,
    pub(super) rows: Vec<RowOutcome>,
    /// Metrics of the average training pose.
    pub(super) mean_pose: Means,
}

/// A row of the table.
#[derive(Debug, Serialize)]
pub(super) struct RowOutcome {
    pub(super) name: &'static str,
    pub(super) about: &'static str,
    #[serde(skip)]
    pub(super) row: &'static Row,
    /// Fields of the config that its one change is made of.
    changes: &'static [&'static str],
    pub(super) means: Means,
    pub(super) parameters: usize,
    pub(super) parameters_as_published: usize,
    pub(super) poses_per_s: Interval,
    pub(super) training_s: Option<Interval>,
    pub(super) validation_loss: Option<Interval>,
    pub(super) findings: Vec<FindingOutcome>,
    per_seed: Vec<Metrics>,
    pub(super) pck_2d: Vec<f64>,
    pub(super) pck_3d: Vec<f64>,
}

/// Means over seeds, by the name of the metric.
pub(super) type Means = BTreeMap<&'static str, Interval>;

/// A published statement and the outcome of its tests.
#[derive(Debug, Serialize)]
pub(super) struct FindingOutcome {
    pub(super) published: &'static str,
    pub(super) relation: Relation,
    pub(super) than: &'static str,
    pub(super) checks: Vec<Check>,
}

/// Test of a statement on one measure.
#[derive(Debug, Serialize)]
pub(super) struct Check {
    pub(super) measure: &'static str,
    /// This row minus the other, seed by seed.
    pub(super) difference: Interval,
    pub(super) verdict: Verdict,
}

/// A measure to compare rows by, larger is better.
struct Measure {
    name: &'static str,
    get: fn(&Trial, &Metrics) -> f64,
}

const ACCURACY: &[Measure] = &[
    Measure { name: "2D", get: |_, figures| figures.auc_2d },
    Measure { name: "3D", get: |_, figures| figures.auc_3d },
];
const SPEED: &[Measure] = &[Measure { name: "poses/s", get: |trial, _| trial.poses_per_s }];

impl Outcome {
    /// The outcome of the rows that have trials.
    pub(super) fn new(
        config: &str,
        seeds: &[u64],
        stride_ms: u32,
        rows: &[&'static Row],
        trials: &Trials,
    ) -> Result<Self> {
        // Rows that differ in evaluation alone share the trials of one network.
        let done = rows.iter().filter(|row| trials.contains_key(row.trained_as()));
        let done: Vec<&'static Row> = done.copied().collect();
        let full = row_trials(trials, FULL)?;
        Ok(Self {
            config: config.to_owned(),
            seeds: seeds.to_vec(),
            stride_ms,
            made: distinct(trials),
            rows: done.iter().map(|row| row_outcome(row, &done, trials)).collect::<Result<_>>()?,
            mean_pose: means(&full.iter().map(|t| t.mean_pose.figures).collect::<Vec<_>>())?,
        })
    }
}

/// Programs and machines of the trials.
fn distinct(trials: &Trials) -> Vec<Provenance> {
    let mut made: Vec<Provenance> = Vec::new();
    for trial in trials.values().flatten() {
        if !made.contains(&trial.made) {
            made.push(trial.made.clone());
        }
    }
    made
}

fn row_trials<'a>(trials: &'a Trials, row: &str) -> Result<&'a [Trial]> {
    trials.get(row).map(Vec::as_slice).with_context(|| format!("row {row} was not run"))
}

fn scores<'a>(row: &Row, trial: &'a Trial) -> &'a Scores {
    if row.is_filtered() { &trial.filtered } else { &trial.unfiltered }
}

fn row_outcome(row: &'static Row, done: &[&Row], trials: &Trials) -> Result<RowOutcome> {
    let ours = row_trials(trials, row.trained_as())?;
    let first = ours.first().context("a row without seeds")?;
    let per_seed: Vec<Metrics> = ours.iter().map(|trial| scores(row, trial).figures).collect();
    let speeds: Vec<f64> = ours.iter().map(|trial| trial.poses_per_s).collect();
    let seconds: Vec<f64> = ours.iter().filter_map(|trial| trial.training_s).collect();
    let losses: Vec<f64> = ours.iter().filter_map(|trial| trial.validation_loss).collect();
    let curve =
        |get: fn(&Scores) -> &[f64]| mean_curve(ours.iter().map(|trial| get(scores(row, trial))));
    // A statement about a row that did not run cannot be checked.
    let known = |finding: &&Finding| done.iter().any(|other| other.name == finding.than);
    let findings = row.published.iter().filter(known);
    Ok(RowOutcome {
        name: row.name,
        about: row.about,
        row,
        changes: row.fields,
        means: means(&per_seed)?,
        parameters: first.parameters,
        parameters_as_published: first.parameters_as_published,
        poses_per_s: t_interval(&speeds).context("no speed was measured")?,
        training_s: t_interval(&seconds),
        validation_loss: t_interval(&losses),
        findings: findings
            .map(|finding| {
                let other = done.iter().find(|other| other.name == finding.than);
                check(row, other.context("the other row was not run")?, finding, trials)
            })
            .collect::<Result<_>>()?,
        per_seed,
        pck_2d: curve(|scores| &scores.pck_2d),
        pck_3d: curve(|scores| &scores.pck_3d),
    })
}

fn means(per_seed: &[Metrics]) -> Result<Means> {
    let mean = |get: fn(&Metrics) -> f64| {
        let values: Vec<f64> = per_seed.iter().map(get).collect();
        t_interval(&values).context("a row without seeds")
    };
    METRICS.iter().map(|&(name, get)| Ok((name, mean(get)?))).collect()
}

fn check(row: &Row, other: &Row, finding: &Finding, trials: &Trials) -> Result<FindingOutcome> {
    let pairs =
        row_trials(trials, row.trained_as())?.iter().zip(row_trials(trials, other.trained_as())?);
    let is_speed = finding.relation == Relation::Slower;
    let measures = if is_speed { SPEED } else { ACCURACY };
    // Times of other machines or devices cannot be compared, accuracies can.
    let is_comparable = !is_speed || pairs.clone().all(|(a, b)| a.made.is_as_fast(&b.made));
    let checks = measures.iter().map(|measure| {
        let value = |row, trial| (measure.get)(trial, &scores(row, trial).figures);
        let differences: Vec<f64> =
            pairs.clone().map(|(a, b)| value(row, a) - value(other, b)).collect();
        let difference = t_interval(&differences).context("rows without seeds")?;
        let verdict = match is_comparable {
            true => finding.relation.verdict(&difference),
            false => Verdict::OtherMachines,
        };
        Ok(Check { measure: measure.name, difference, verdict })
    });
    Ok(FindingOutcome {
        published: finding.words,
        relation: finding.relation,
        than: finding.than,
        checks: checks.collect::<Result<_>>()?,
    })
}

#[cfg(test)]
pub(super) mod tests {
    use evpose_task::hand::HandConfig;

    use super::super::rows::ROWS;
    use super::super::selection::selected;
    use super::*;

    /// Trials of one row whose areas are these, one a seed; unfiltered ones are 0.1 lower.
    pub(crate) fn trials(row: &str, areas: &[f64], poses_per_s: f64) -> Vec<Trial> {
        let scores = |auc: f64| {
            serde_json::json!({
                "figures": {
                    "auc_2d": auc, "auc_3d": auc, "mpjpe_mm": 100.0 * (1.0 - auc),
                    "translation_mm": 30.0, "rotation_deg": 20.0, "articulation": 0.5,
                },
                "pck_2d": [0.0, auc], "pck_3d": [0.0, auc],
            })
        };
        let trial = |(seed, &auc): (usize, &f64)| {
            serde_json::from_value(serde_json::json!({
                "row": row, "seed": seed, "stride_ms": 1,
                "made": { "commit": "test", "machine": "one", "device": "flex" },
                "parameters": 7, "parameters_as_published": 70,
                "training_s": 60.0, "validation_loss": 1.0 - auc, "poses_per_s": poses_per_s,
                "filtered": scores(auc), "unfiltered": scores(auc - 0.1),
                "mean_pose": scores(0.1),
            }))
        };
        areas.iter().enumerate().map(trial).collect::<Result<_, _>>().expect("a trial")
    }

    pub(crate) fn outcome(areas: &[(&'static str, [f64; 3])]) -> Result<Outcome> {
        let of_row = |&(row, areas): &(&'static str, [f64; 3])| (row, trials(row, &areas, 500.0));
        let trials: Trials = areas.iter().map(of_row).collect();
        let rows: Vec<&Row> = ROWS.iter().collect();
        Outcome::new("test", &[1, 2, 3], 1, &rows, &trials)
    }

    fn verdicts(outcome: &Outcome, row: &str) -> Vec<(&'static str, Vec<Verdict>)> {
        let row = outcome.rows.iter().find(|outcome| outcome.name == row);
        row.map_or_else(Vec::new, |row| {
            let verdicts = |finding: &FindingOutcome| {
                (finding.than, finding.checks.iter().map(|check| check.verdict).collect())
            };
            row.findings.iter().map(verdicts).collect()
        })
    }

    #[test]
    fn differences_are_taken_seed_by_seed() -> Result<()> {
        // Seeds differ by far more than rows: unpaired, nothing could be concluded.
        let outcome = outcome(&[
            (FULL, [0.30, 0.50, 0.70]),
            ("eoi", [0.28, 0.48, 0.68]),
            ("eci", [0.32, 0.52, 0.72]),
            ("eci-s", [0.33, 0.47, 0.70]),
        ])?;
        assert_eq!(verdicts(&outcome, "eoi"), [(FULL, vec![Verdict::Found; 2])]);
        assert_eq!(verdicts(&outcome, "eci"), [(FULL, vec![Verdict::Reversed; 2])]);
        assert_eq!(verdicts(&outcome, "eci-s"), [(FULL, vec![Verdict::WithinNoise; 2])]);
        let full = &outcome.rows[0].means["auc_3d"];
        assert!(full.low.is_some_and(|low| low < 0.28), "{full:?}");
        Ok(())
    }

    #[test]
    fn the_row_without_filter_is_the_full_method_evaluated_otherwise() -> Result<()> {
        let outcome = outcome(&[(FULL, [0.5, 0.6, 0.7]), ("no-augmentation", [0.2, 0.3, 0.4])])?;
        let names: Vec<_> = outcome.rows.iter().map(|row| row.name).collect();
        assert_eq!(names, [FULL, "no-augmentation", "no-filter"]);
        assert!((outcome.rows[2].means["auc_2d"].estimate - 0.5).abs() < 1e-9);
        assert_eq!(verdicts(&outcome, "no-filter"), [(FULL, vec![Verdict::Found; 2])]);
        let found = vec![Verdict::Found; 2];
        let both = [(FULL, found.clone()), ("no-filter", found)];
        assert_eq!(verdicts(&outcome, "no-augmentation"), both);
        Ok(())
    }

    #[test]
    fn findings_about_rows_that_did_not_run_are_left_out() -> Result<()> {
        let trials: Trials = [FULL, "no-augmentation"]
            .map(|row| (row, trials(row, &[0.5, 0.6], 500.0)))
            .into_iter()
            .collect();
        let rows = selected(
            &["no-augmentation".to_owned(), "resnet34".to_owned()],
            &HandConfig::default(),
        )
        .0;
        let outcome = Outcome::new("test", &[1, 2], 1, &rows, &trials)?;
        assert_eq!(outcome.rows.len(), 2);
        assert_eq!(verdicts(&outcome, "no-augmentation").len(), 1);
        Ok(())
    }

    #[test]
    fn a_network_is_slower_by_its_speed_and_not_by_its_accuracy() -> Result<()> {
        let rows = selected(&["resnet34".to_owned()], &HandConfig::default()).0;
        let trials: Trials = [
            (FULL, trials(FULL, &[0.5, 0.6, 0.7], 900.0)),
            ("resnet34", trials("resnet34", &[0.501, 0.6, 0.7], 400.0)),
        ]
        .into_iter()
        .collect();
        let outcome = Outcome::new("test", &[1, 2, 3], 1, &rows, &trials)?;
        let found = |checks: usize| (FULL, vec![Verdict::Found; checks]);
        assert_eq!(verdicts(&outcome, "resnet34"), [found(2), found(1)]);
        Ok(())
    }

    #[test]
    fn speeds_of_two_machines_are_not_compared_and_both_are_named() -> Result<()> {
        let rows = selected(&["resnet34".to_owned()], &HandConfig::default()).0;
        let mut elsewhere = trials("resnet34", &[0.2, 0.3, 0.4], 400.0);
        elsewhere[1].made.machine = "another".to_owned();
        let trials: Trials =
            [(FULL, trials(FULL, &[0.5, 0.6, 0.7], 900.0)), ("resnet34", elsewhere)]
                .into_iter()
                .collect();
        let outcome = Outcome::new("test", &[1, 2, 3], 1, &rows, &trials)?;
        let machines: Vec<&str> = outcome.made.iter().map(|made| &*made.machine).collect();
        assert_eq!(machines, ["one", "another"]);
        let verdicts = verdicts(&outcome, "resnet34");
        assert_eq!(verdicts[0], (FULL, vec![Verdict::Reversed; 2]));
        assert_eq!(verdicts[1], (FULL, vec![Verdict::OtherMachines]));
        Ok(())
    }
}
