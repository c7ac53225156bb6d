//! The results of a search: trials from the best to the worst, as JSON and as a table.

use std::collections::BTreeMap;

use serde::Serialize;
use toml::Value;

use crate::tune::args::TuneMethod;
use crate::tune::plan::order;
use crate::tune::rung_result::{RungResult, TrialStatus, ValidationMeans};
use crate::tune::space::inline;

/// Content of `tune.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct SearchOutcome {
    pub(crate) schema: u32,
    pub(crate) task: &'static str,
    /// The network of the config as it is, and the length of its training.
    pub(crate) network: String,
    pub(crate) seed: u64,
    pub(crate) method: TuneMethod,
    /// The logged value that trials are ranked by.
    pub(crate) rank: String,
    pub(crate) higher_is_better: bool,
    /// Names of the logged values.
    pub(crate) logged: Vec<&'static str>,
    /// Dotted names of the fields that were searched.
    pub(crate) parameters: Vec<String>,
    /// Optimiser steps at the end of each rung.
    pub(crate) rungs: Vec<u64>,
    /// Number of trials, those without a result included.
    #[serde(rename = "trial_count")]
    pub(crate) count: u64,
    /// Whether every trial of every rung has a result.
    pub(crate) is_complete: bool,
    /// Trials with a result, the best first: those of later rungs before those of earlier ones.
    pub(crate) trials: Vec<TrialOutcome>,
}

/// A trial in the last rung that it has a result of.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct TrialOutcome {
    /// Index from 0; trial 0 is the config as it is.
    pub(crate) trial: u64,
    /// Values of the fields; those that the config does not have are left out.
    pub(crate) values: BTreeMap<String, Value>,
    /// The last rung with a result, from 1.
    pub(crate) rung: usize,
    pub(crate) status: TrialStatus,
    /// Optimiser steps until its last validation.
    pub(crate) steps: u64,
    /// The value that trials are ranked by; none for one that diverged.
    pub(crate) score: Option<f64>,
    /// The validation of the checkpoint that the training keeps.
    pub(crate) best: Option<ValidationMeans>,
    pub(crate) validations: Vec<ValidationMeans>,
}

/// The trials of a rung with their results; none for those that have none yet.
pub(crate) type RungResults = Vec<(u64, Option<RungResult>)>;

impl SearchOutcome {
    /// Fills in the trials from the results of each rung that has begun; `values` are those of the
    /// parameters of a trial, in their order.
    pub(crate) fn fill(
        &mut self,
        rungs: &[RungResults],
        values: impl Fn(u64) -> Vec<Option<Value>>,
    ) {
        let mut last: BTreeMap<u64, (usize, &RungResult)> = BTreeMap::new();
        // The last rung that a trial has finished holds its result.
        for (rung, results) in rungs.iter().enumerate() {
            for (trial, result) in results {
                if let Some(result) = result {
                    last.insert(*trial, (rung + 1, result));
                }
            }
        }
        self.is_complete = rungs.len() == self.rungs.len()
            && rungs.iter().flatten().all(|(_, result)| result.is_some());
        let named = |trial: u64| {
            let pairs = self.parameters.iter().cloned().zip(values(trial));
            pairs.filter_map(|(field, value)| Some((field, value?))).collect()
        };
        let trials = last.into_iter().map(|(trial, (rung, result))| TrialOutcome {
            trial,
            values: named(trial),
            rung,
            status: result.status,
            steps: result.steps(),
            score: result.score(&self.rank),
            best: result.best().cloned(),
            validations: result.validations.clone(),
        });
        let mut trials: Vec<TrialOutcome> = trials.collect();
        // Later rungs first: scores after different numbers of steps cannot be compared.
        trials.sort_by(|one, other| {
            let by_score =
                order(&(one.trial, one.score), &(other.trial, other.score), self.higher_is_better);
            other.rung.cmp(&one.rung).then(by_score)
        });
        self.trials = trials;
    }

    pub(crate) fn best(&self) -> Option<&TrialOutcome> {
        self.trials.first().filter(|trial| trial.score.is_some())
    }

    /// Headings of the table.
    pub(crate) fn header(&self) -> Vec<&str> {
        let fields = self.parameters.iter().map(String::as_str);
        let ends = ["rung", "steps", "status", "best_step"];
        std::iter::once("trial").chain(fields).chain(ends).chain(self.logged.clone()).collect()
    }

    pub(crate) fn row(&self, trial: &TrialOutcome) -> Vec<String> {
        let mut cells = vec![trial.trial.to_string()];
        cells.extend(self.parameters.iter().map(|field| trial.value(field)));
        cells.extend([trial.rung.to_string(), trial.steps.to_string()]);
        cells.push(trial.status.name().to_owned());
        cells.push(trial.best.as_ref().map_or_else(String::new, |best| best.step.to_string()));
        let logged = |name: &&str| trial.best.as_ref().and_then(|best| best.values.get(*name));
        cells.extend(
            self.logged.iter().map(|name| logged(name).map_or_else(String::new, f64::to_string)),
        );
        cells
    }

    /// Content of `trials.csv`: the best first.
    pub(crate) fn csv(&self) -> String {
        let header = self.header().into_iter().map(str::to_owned).collect();
        let rows = self.trials.iter().map(|trial| self.row(trial));
        let lines = std::iter::once(header).chain(rows).map(|cells: Vec<String>| {
            cells.iter().map(|cell| csv_cell(cell)).collect::<Vec<_>>().join(",") + "\n"
        });
        lines.collect()
    }

    /// Comment at the head of `best.toml`.
    pub(crate) fn heading(&self) -> String {
        let Some(best) = self.best() else { return String::new() };
        let mut text = format!("# Trial {} of {}: {}", best.trial, self.count, self.score(best));
        text += ", by `evpose tune`.\n";
        // In the order of the file of ranges.
        let values = self.parameters.iter().filter_map(|f| Some((f, best.values.get(f)?)));
        values.for_each(|(field, value)| text += &format!("# {field} = {}\n", inline(value)));
        text + "\n"
    }

    /// `loss 0.1234 at step 400`.
    pub(crate) fn score(&self, trial: &TrialOutcome) -> String {
        match (trial.score, &trial.best) {
            (Some(score), Some(best)) => {
                format!("{} {score:.4} at step {}", self.rank, best.step)
            }
            _ => trial.status.name().to_owned(),
        }
    }
}

impl TrialOutcome {
    /// The value of a field as a table has it; empty if the config does not have the field.
    pub(crate) fn value(&self, field: &str) -> String {
        match self.values.get(field) {
            Some(Value::String(text)) => text.clone(),
            Some(value) => inline(value),
            None => String::new(),
        }
    }
}

/// A cell of a table of comma-separated values (RFC 4180).
fn csv_cell(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::tune::rung_result::tests::result;

    pub(crate) fn outcome(rank: &str, rungs: &[RungResults]) -> SearchOutcome {
        let mut outcome = SearchOutcome {
            schema: 1,
            task: "hand",
            network: "a network".to_owned(),
            seed: 1,
            method: TuneMethod::Halving,
            rank: rank.to_owned(),
            higher_is_better: rank != "loss",
            logged: vec!["loss", "accuracy"],
            parameters: vec!["training.learning_rate".to_owned(), "network.backbone".to_owned()],
            rungs: vec![20, 40],
            count: 4,
            is_complete: false,
            trials: Vec::new(),
        };
        let values = |trial: u64| {
            let rate = (trial > 0).then_some(Value::Float(1e-3 * trial as f64));
            vec![rate, Some(Value::String(format!("net, {trial}")))]
        };
        outcome.fill(rungs, values);
        outcome
    }

    pub(crate) fn rungs() -> Vec<RungResults> {
        use TrialStatus::{Diverged, Paused, Trained};
        let first = vec![
            (0, Some(result(Paused, &[0.5, 0.4]))),
            (1, Some(result(Diverged, &[0.1]))),
            (2, Some(result(Paused, &[0.6, 0.3]))),
            (3, Some(result(Paused, &[0.6, 0.35]))),
        ];
        let second = vec![
            (2, Some(result(Trained, &[0.6, 0.3, 0.4, 0.5]))),
            (3, Some(result(Trained, &[0.6, 0.35, 0.2, 0.3]))),
        ];
        vec![first, second]
    }

    #[test]
    fn trials_are_ranked_by_rung_then_score_and_those_that_diverged_are_last() {
        let outcome = outcome("loss", &rungs());
        let order: Vec<(u64, usize)> = outcome.trials.iter().map(|t| (t.trial, t.rung)).collect();
        assert_eq!(order, [(3, 2), (2, 2), (0, 1), (1, 1)]);
        assert!(outcome.is_complete);
        assert_eq!(outcome.best().map(|best| (best.trial, best.score)), Some((3, Some(0.2))));
        assert!(outcome.heading().starts_with("# Trial 3 of 4: loss 0.2000 at step 30"));
    }

    #[test]
    fn a_search_without_its_last_rung_is_not_complete() {
        assert!(!outcome("loss", &rungs()[..1]).is_complete);
        let mut rungs = rungs();
        rungs[1][1].1 = None;
        let outcome = outcome("accuracy", &rungs);
        assert!(!outcome.is_complete);
        assert_eq!(outcome.best().map(|best| best.trial), Some(2), "the only one that is trained");
    }

    #[test]
    fn the_table_has_a_row_for_every_trial_and_quotes_what_has_commas() {
        let csv = outcome("loss", &rungs()).csv();
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!(
            lines[0],
            "trial,training.learning_rate,network.backbone,rung,steps,status,best_step,loss,accuracy"
        );
        assert_eq!(lines[1], "3,0.003,\"net, 3\",2,40,trained,30,0.2,0.8");
        assert_eq!(lines[3], "0,,\"net, 0\",1,20,paused,20,0.4,0.6");
        assert_eq!(lines.len(), 5);
    }
}
