//! The result of a trial at the end of a rung.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Result;
use evpose_train::training::TrainingSpan;
use evpose_train::{LOSS, LoggedValue, read_history, validation_means};
use serde::{Deserialize, Serialize};

/// How a trial left a rung.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum TrialStatus {
    /// It can go on from its checkpoint.
    Paused,
    /// It was trained to its end.
    Trained,
    /// Its loss stopped being finite.
    Diverged,
}

impl TrialStatus {
    /// In tables.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Paused => "paused",
            Self::Trained => "trained",
            Self::Diverged => "diverged",
        }
    }
}

/// The result of a trial at the end of a rung. The same bytes whoever trained it, and when.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct RungResult {
    /// How it left the rung.
    pub(crate) status: TrialStatus,
    /// Its validations, in the order of their steps.
    pub(crate) validations: Vec<ValidationMeans>,
}

/// Means of the logged values over one validation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ValidationMeans {
    /// Optimiser steps before it.
    pub(crate) step: u64,
    /// By name; those that are not finite are left out.
    pub(crate) values: BTreeMap<String, f64>,
}

impl RungResult {
    /// Reads the validations that the training in the directory `run` has logged.
    pub(crate) fn of_run(
        run: &Path,
        status: TrialStatus,
        length: TrainingSpan,
        logged: &[LoggedValue],
    ) -> Result<Self> {
        let history = read_history(&run.join("metrics.jsonl"))?;
        let mut validations: BTreeMap<usize, BTreeMap<String, f64>> = BTreeMap::new();
        for value in logged {
            for (interval, mean) in validation_means(&history, value.name) {
                let values = validations.entry(interval).or_default();
                // A validation that diverged keeps its interval, without values.
                if mean.is_finite() {
                    values.insert(value.name.to_owned(), mean);
                }
            }
        }
        // The last interval may be cut short.
        let at =
            |interval: usize| (interval as u64 * length.steps_per_validation).min(length.steps);
        let validations = validations
            .into_iter()
            .map(|(interval, values)| ValidationMeans { step: at(interval), values });
        Ok(Self { status, validations: validations.collect() })
    }

    /// The validation of the checkpoint that the training keeps: that of the lowest loss, the
    /// earliest of equals. None if there is none with a finite loss.
    pub(crate) fn best(&self) -> Option<&ValidationMeans> {
        let losses = self.validations.iter().filter_map(|v| Some((v, *v.values.get(LOSS)?)));
        losses.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(validation, _)| validation)
    }

    /// The logged value `name` at that checkpoint. None for a trial that diverged.
    pub(crate) fn score(&self, name: &str) -> Option<f64> {
        if self.status == TrialStatus::Diverged {
            return None;
        }
        self.best()?.values.get(name).copied()
    }

    /// Optimiser steps until the last validation.
    pub(crate) fn steps(&self) -> u64 {
        self.validations.last().map_or(0, |validation| validation.step)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    /// A result with these losses, one validation every 10 steps; accuracies are one minus them.
    pub(crate) fn result(status: TrialStatus, losses: &[f64]) -> RungResult {
        let validation = |(index, &loss): (usize, &f64)| ValidationMeans {
            step: 10 * (index as u64 + 1),
            values: BTreeMap::from([(LOSS.to_owned(), loss), ("accuracy".to_owned(), 1.0 - loss)]),
        };
        RungResult { status, validations: losses.iter().enumerate().map(validation).collect() }
    }

    #[test]
    fn the_score_is_that_of_the_checkpoint_that_is_kept() {
        let mut trained = result(TrialStatus::Trained, &[0.5, 0.2, 0.3]);
        // A better accuracy elsewhere is of no use: that network is not kept.
        trained.validations[2].values.insert("accuracy".to_owned(), 0.9);
        assert_eq!(trained.best().unwrap().step, 20);
        assert_eq!((trained.score("loss"), trained.score("accuracy")), (Some(0.2), Some(0.8)));
        assert_eq!((trained.score("other"), trained.steps()), (None, 30));
        let diverged = result(TrialStatus::Diverged, &[0.1]);
        assert_eq!(diverged.score("loss"), None);
        assert_eq!(result(TrialStatus::Paused, &[]).score("loss"), None);
    }

    #[test]
    fn validations_are_read_from_the_log_of_a_run_at_their_steps() {
        let directory = tempfile::tempdir().unwrap();
        let line = |interval: usize, part: &str, loss: &str| {
            format!(
                "{{\"interval\":{interval},\"batch\":1,\"part\":\"{part}\",\"samples\":4,\
                 \"values\":{{\"loss\":{loss}}}}}\n"
            )
        };
        let log = [
            line(1, "train", "9.0"),
            line(1, "valid", "4.0"),
            line(1, "valid", "2.0"),
            line(2, "valid", "null"),
            line(3, "valid", "1.0"),
        ];
        std::fs::write(directory.path().join("metrics.jsonl"), log.concat()).unwrap();
        let length = TrainingSpan { batch_size: 4, steps_per_validation: 5, steps: 12 };
        let logged = [LoggedValue { name: LOSS, unit: "", higher_is_better: false }];
        let read =
            RungResult::of_run(directory.path(), TrialStatus::Trained, length, &logged).unwrap();
        let steps: Vec<u64> = read.validations.iter().map(|v| v.step).collect();
        assert_eq!(steps, [5, 10, 12], "the last interval is a short one");
        assert_eq!(read.validations[0].values["loss"], 3.0);
        assert!(read.validations[1].values.is_empty());
        let text = serde_json::to_string(&read).unwrap();
        assert_eq!(serde_json::from_str::<RungResult>(&text).unwrap(), read);
    }
}
