//! How many trials are trained, for how long, and which of them go on.
//!
//! # Source
//! Successive halving: Jamieson, Talwalkar: *Non-stochastic best arm identification and
//! hyperparameter optimization*, AISTATS 2016.

use std::cmp::Ordering;

use anyhow::{Result, ensure};
use evpose_train::training::TrainingSpan;
use serde::Serialize;

/// A rung of successive halving: the number of trials, and the step until which they are trained.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(crate) struct Rung {
    pub(crate) trials: u64,
    /// Optimiser steps from the start of the training at which they pause, a whole number of
    /// validation intervals; none trains to the end.
    pub(crate) pause_after: Option<u64>,
}

/// The rungs, from the shortest training to the whole one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct TrialPlan {
    rungs: Vec<Rung>,
    /// Optimiser steps of a whole training.
    steps: u64,
}

impl TrialPlan {
    pub(crate) fn random(trials: u64, length: TrainingSpan) -> Self {
        Self { rungs: vec![Rung { trials, pause_after: None }], steps: length.steps }
    }

    /// The best of `eta` trials goes from a rung to the next, in which it is trained for `eta`
    /// times as many steps. Without `rungs` there are as many as `trials` and validations allow.
    pub(crate) fn halving(
        trials: u64,
        eta: u64,
        rungs: Option<u32>,
        length: TrainingSpan,
    ) -> Result<Self> {
        let validations = length.steps.div_ceil(length.steps_per_validation);
        let fits = |rungs: u32| {
            // The first rung has to reach a validation, the last one needs a trial.
            let factor = eta.checked_pow(rungs - 1);
            factor.is_some_and(|factor| {
                factor <= trials && length.steps / factor >= length.steps_per_validation
            })
        };
        // More than 20 rungs would need at least 2^20 trials.
        let allowed = (1..=20).take_while(|&rungs| fits(rungs)).last().unwrap_or(1);
        ensure!(
            allowed > 1,
            "--method halving: nothing to halve: one in {eta} of {trials} trials would go on, and a training has \
             {validations} validations. Take at least {eta} trials, a smaller --eta, or shorter \
             `training.steps_per_validation`"
        );
        let count = rungs.unwrap_or(allowed);
        ensure!(
            count <= allowed,
            "--rungs {count}: with --eta {eta}, {trials} trials and {validations} validations of a training allow \
             {allowed}. Take fewer rungs, more trials, or shorter `training.steps_per_validation`"
        );
        let rung = |index: u32| {
            let steps = length.steps / eta.pow(count - 1 - index);
            // To the end of an interval, since trainings pause at validations only.
            let intervals = steps.div_ceil(length.steps_per_validation);
            let is_last = index + 1 == count;
            Rung {
                trials: trials / eta.pow(index),
                pause_after: (!is_last).then_some(intervals * length.steps_per_validation),
            }
        };
        Ok(Self { rungs: (0..count).map(rung).collect(), steps: length.steps })
    }

    pub(crate) fn rungs(&self) -> &[Rung] {
        &self.rungs
    }

    pub(crate) fn steps_of(&self, rung: usize) -> u64 {
        self.rungs[rung].pause_after.unwrap_or(self.steps).min(self.steps)
    }

    pub(crate) fn added_steps(&self, rung: usize) -> u64 {
        self.steps_of(rung) - if rung == 0 { 0 } else { self.steps_of(rung - 1) }
    }

    pub(crate) fn total_steps(&self) -> u64 {
        (0..self.rungs.len()).map(|rung| self.rungs[rung].trials * self.added_steps(rung)).sum()
    }

    /// The plan in a line for each rung.
    pub(crate) fn description(&self) -> Vec<String> {
        let line = |rung: usize| {
            let trials = self.rungs[rung].trials;
            format!("rung {}: {trials} trials to step {}", rung + 1, self.steps_of(rung))
        };
        let mut lines: Vec<String> = (0..self.rungs.len()).map(line).collect();
        let whole = self.total_steps() as f64 / self.steps as f64;
        lines.push(format!("the work of {whole:.1} whole trainings"));
        lines
    }
}

/// A trial with its score; none for one that diverged.
pub(crate) type Scored = (u64, Option<f64>);

/// The order of two trials, the better first: by score, then by index. Trials without a score come
/// last.
pub(crate) fn order(one: &Scored, other: &Scored, higher_is_better: bool) -> Ordering {
    let by_score = match (one.1, other.1) {
        (Some(a), Some(b)) if higher_is_better => b.total_cmp(&a),
        (Some(a), Some(b)) => a.total_cmp(&b),
        (Some(_), None) => Ordering::Less,
        (None, Some(_)) => Ordering::Greater,
        (None, None) => Ordering::Equal,
    };
    by_score.then(one.0.cmp(&other.0))
}

/// The best `count` trials that have a score, in the order of their indices.
pub(crate) fn promoted(mut trials: Vec<Scored>, count: u64, higher_is_better: bool) -> Vec<u64> {
    // A trial that diverged has no checkpoint that is worth going on from.
    trials.retain(|(_, score)| score.is_some());
    trials.sort_by(|one, other| order(one, other, higher_is_better));
    trials.truncate(count as usize);
    let mut promoted: Vec<u64> = trials.into_iter().map(|(trial, _)| trial).collect();
    promoted.sort_unstable();
    promoted
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn length(steps: u64, steps_per_validation: u64) -> TrainingSpan {
        TrainingSpan { batch_size: 4, steps_per_validation, steps }
    }

    fn rungs(plan: &TrialPlan) -> Vec<(u64, u64)> {
        (0..plan.rungs.len()).map(|i| (plan.rungs[i].trials, plan.steps_of(i))).collect()
    }

    #[test]
    fn a_third_goes_on_for_three_times_as_long() {
        let plan = TrialPlan::halving(27, 3, None, length(2700, 100)).unwrap();
        assert_eq!(rungs(&plan), [(27, 100), (9, 300), (3, 900), (1, 2700)]);
        assert_eq!(plan.rungs[3].pause_after, None);
        // 27 of 100, 9 of 200, 3 of 600, 1 of 1800.
        assert_eq!(plan.total_steps(), 2700 + 1800 + 1800 + 1800);
        assert!(plan.description().last().unwrap().contains("3.0 whole trainings"));
    }

    #[test]
    fn rungs_end_at_validations_and_get_longer() {
        let plan = TrialPlan::halving(10, 3, None, length(1000, 60)).unwrap();
        assert_eq!(rungs(&plan), [(10, 120), (3, 360), (1, 1000)]);
        // As few validations as there are.
        let plan = TrialPlan::halving(100, 2, None, length(1000, 300)).unwrap();
        assert_eq!(rungs(&plan), [(100, 600), (50, 1000)]);
        let plan = TrialPlan::halving(27, 3, Some(2), length(2700, 100)).unwrap();
        assert_eq!(rungs(&plan), [(27, 900), (9, 2700)]);
    }

    #[test]
    fn a_plan_that_cannot_be_is_refused_with_the_remedy() {
        let one = TrialPlan::halving(2, 3, None, length(900, 100)).unwrap_err();
        assert!(one.to_string().contains("at least 3 trials"), "{one}");
        let one = TrialPlan::halving(9, 3, None, length(900, 900)).unwrap_err();
        assert!(one.to_string().contains("1 validations"), "{one}");
        let many = TrialPlan::halving(9, 3, Some(4), length(900, 10)).unwrap_err();
        assert!(many.to_string().contains("allow 3"), "{many}");
    }

    #[test]
    fn the_best_go_on_and_trials_that_diverged_do_not() {
        let trials =
            vec![(0, Some(0.3)), (1, None), (2, Some(0.1)), (3, Some(0.3)), (4, Some(0.5))];
        assert_eq!(promoted(trials.clone(), 2, false), [0, 2], "the earlier of equals");
        assert_eq!(promoted(trials.clone(), 2, true), [0, 4]);
        assert_eq!(promoted(trials, 9, false), [0, 2, 3, 4]);
    }
}
