//! Means of all rows over seeds, compared with the published results.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use evpose_core::stats::interval::{Interval, t_interval};
use serde::Serialize;

use super::rows::{FULL, Row};
use super::trial::Trial;
use crate::ablate::finding::Verdict;
use crate::study::{VERDICTS, listed, markdown_table, mean_curve, pck_chart};
use evpose_report::colour::PALETTE;
use evpose_report::format::with_interval;
use evpose_report::html::HtmlPage;

/// The trials of every row, by its name, in the order of the seeds.
pub(super) type Trials = BTreeMap<&'static str, Vec<Trial>>;

/// Content of `ablation.json`.
#[derive(Debug, Serialize)]
pub(super) struct Outcome {
    seeds: Vec<u64>,
    rows: Vec<RowOutcome>,
    /// Of the mean training pose, at 0.4 of the torso.
    mean_pose_40: Interval,
}

#[derive(Debug, Serialize)]
struct RowOutcome {
    name: &'static str,
    about: &'static str,
    pck_40: Interval,
    pck_80: Interval,
    auc: Interval,
    mpjpe_px: Interval,
    training_s: Option<Interval>,
    published: Option<[f64; 2]>,
    /// This row minus the full method at 0.4, seed by seed.
    difference_40: Interval,
    /// Published order relative to the full method, and whether it is reproduced.
    expected: Option<String>,
    verdict: Option<Verdict>,
    curve: Vec<f64>,
    per_seed: Vec<Trial>,
}

impl Outcome {
    /// The outcome of the rows that have trials.
    pub(super) fn new(seeds: &[u64], rows: &[&'static Row], trials: &Trials) -> Result<Self> {
        let full = trials.get(FULL).context("the full method has no trials")?;
        let outcomes = rows.iter().filter_map(|row| Some((row, trials.get(row.name)?)));
        Ok(Self {
            seeds: seeds.to_vec(),
            rows: outcomes
                .map(|(row, trials)| outcome_of(row, trials, full))
                .collect::<Result<_>>()?,
            mean_pose_40: mean(full.iter().map(|trial| trial.mean_pose_40))?,
        })
    }
}

fn outcome_of(row: &'static Row, trials: &[Trial], full: &[Trial]) -> Result<RowOutcome> {
    let of = |get: fn(&Trial) -> f64| mean(trials.iter().map(get));
    // Seed by seed: both rows share the random draws of a seed.
    let difference_40 =
        mean(trials.iter().zip(full).map(|(trial, full)| trial.pck_40 - full.pck_40))?;
    // One seed without a time: no mean.
    let times: Option<Vec<f64>> = trials.iter().map(|trial| trial.training_s).collect();
    Ok(RowOutcome {
        name: row.name,
        about: row.about,
        pck_40: of(|trial| trial.pck_40)?,
        pck_80: of(|trial| trial.pck_80)?,
        auc: of(|trial| trial.auc)?,
        mpjpe_px: of(|trial| trial.mpjpe_px)?,
        training_s: times.and_then(|times| t_interval(&times)),
        published: row.published,
        expected: row.expected.map(|relation| format!("{} {FULL}", relation.words())),
        verdict: row.expected.map(|relation| relation.verdict(&difference_40)),
        difference_40,
        curve: mean_curve(trials.iter().map(|trial| &*trial.curve)),
        per_seed: trials.to_vec(),
    })
}

fn mean(values: impl Iterator<Item = f64>) -> Result<Interval> {
    t_interval(&values.collect::<Vec<_>>()).context("a row without trials")
}

/// Headings of the table.
const HEADER: [&str; 9] = [
    "row",
    "PCK@0.4",
    "PCK@0.8",
    "AUC",
    "MPJPE px",
    "published 0.4 / 0.8",
    "difference at 0.4",
    "published: here",
    "training s",
];

fn cells(row: &RowOutcome) -> [String; 9] {
    let published = row
        .published
        .map_or_else(|| "-".to_owned(), |[at_40, at_80]| format!("{at_40:.2} / {at_80:.2}"));
    let said = row.expected.as_ref().zip(row.verdict);
    [
        row.name.to_owned(),
        with_interval(&row.pck_40, 3),
        with_interval(&row.pck_80, 3),
        with_interval(&row.auc, 3),
        with_interval(&row.mpjpe_px, 1),
        published,
        with_interval(&row.difference_40, 3),
        said.map_or_else(|| "-".to_owned(), |(expected, verdict)| format!("{expected}: {verdict}")),
        row.training_s.as_ref().map_or_else(|| "-".to_owned(), |s| format!("{:.0}", s.estimate)),
    ]
}

fn legend(outcome: &Outcome) -> String {
    format!(
        "Means over seeds {} with 95% intervals of Student's t. The mean training pose has PCK@0.4 {}. \
         Published figures are of eH3.6M, not of these people. Verdicts follow from the interval of the \
         difference to the full method, seed by seed: {VERDICTS}.",
        listed(&outcome.seeds),
        with_interval(&outcome.mean_pose_40, 3),
    )
}

/// The table as Markdown.
pub(super) fn markdown(outcome: &Outcome) -> String {
    let rows = outcome.rows.iter().map(cells);
    markdown_table(&HEADER, rows) + &format!("\n{}\n", legend(outcome))
}

/// The page, in one piece.
pub(super) fn html(outcome: &Outcome, configs: &str) -> Result<String> {
    let mut page = HtmlPage::new(
        "What each part of the method for bodies is worth",
        "Networks trained and evaluated by evpose on this machine, on people that are in no training set.",
    );
    page.section("All rows", &legend(outcome));
    page.text_table(&HEADER, outcome.rows.iter().map(cells));
    page.section("Correct joints", "The share of joints nearer than a threshold, mean over seeds.");
    // A chart has no more curves than there are colours.
    let parts = outcome.rows.chunks(PALETTE.len());
    let parts = parts.map(|rows| pck_chart(rows.iter().map(|row| (row.name, &*row.curve))));
    page.plots(&parts.collect::<Result<Vec<_>>>()?);
    let about = outcome.rows.iter().map(|row| format!("{}: {}", row.name, row.about));
    page.details("Rows", &about.collect::<Vec<_>>().join("\n"));
    page.details("Configs of both stages", configs);
    Ok(page.finish())
}
