//! Means of all systems over seeds, and published orderings compared with them.

use std::collections::BTreeMap;

use crate::ablate::{Relation, Verdict};
use anyhow::{Context, Result};
use evpose_core::stats::interval::{Interval, t_interval};
use serde::Serialize;

use crate::compare::measure::{DataSet, Measure};
use crate::compare::ordering::{ORDERINGS, Ordering, TestedOrdering};
use crate::compare::system::{Figure, System};
use crate::compare::trial::Trial;
use crate::study::mean_curve;

/// Results of systems, by their names.
pub(crate) type Results = BTreeMap<&'static str, SystemResult>;

/// Trials of a system in the order of the seeds, or why there are none.
#[derive(Debug, Clone)]
pub(crate) enum SystemResult {
    Ran(Vec<Trial>),
    Missing(String),
}

/// Content of `comparison.json`.
#[derive(Debug, Serialize)]
pub(crate) struct Outcome {
    pub(crate) seeds: Vec<u64>,
    /// The data that systems were evaluated on, in words.
    pub(crate) data: String,
    /// Processors that systems were timed on.
    pub(crate) machines: Vec<String>,
    pub(crate) systems: Vec<SystemOutcome>,
    pub(crate) orderings: Vec<TestedOrdering>,
}

/// A system's row.
#[derive(Debug, Serialize)]
pub(crate) struct SystemOutcome {
    pub(crate) name: &'static str,
    pub(crate) about: &'static str,
    pub(crate) images: &'static str,
    /// Why it did not run, and how to make it.
    pub(crate) missing: Option<String>,
    /// Means over seeds, by measure; those that it has.
    pub(crate) means: Vec<Mean>,
    /// Mean share of correct joints at 1 %, 2 %, …, 100 %.
    pub(crate) curve: Vec<f64>,
    pub(crate) training_s: Option<Interval>,
    pub(crate) published: Vec<PublishedFigure>,
    per_seed: Vec<Trial>,
}

/// The mean of a measure over seeds.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Mean {
    pub(crate) measure: Measure,
    pub(crate) value: Interval,
}

/// A published figure.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct PublishedFigure {
    pub(crate) measure: Measure,
    pub(crate) data_set: DataSet,
    pub(crate) value: f64,
}

impl Outcome {
    /// The outcome of the systems that have results.
    pub(crate) fn new(
        seeds: &[u64],
        data: &str,
        systems: &[&'static System],
        results: &Results,
    ) -> Result<Self> {
        let outcomes =
            systems.iter().filter_map(|system| Some((system, results.get(system.name)?)));
        let mut machines: Vec<String> =
            results.values().flat_map(SystemResult::trials).map(|t| t.machine.clone()).collect();
        machines.sort();
        machines.dedup();
        Ok(Self {
            seeds: seeds.to_vec(),
            data: data.to_owned(),
            machines,
            systems: outcomes
                .map(|(system, result)| outcome_of(system, result))
                .collect::<Result<_>>()?,
            orderings: ORDERINGS
                .iter()
                .filter(|ordering| {
                    // Statements about systems that were not asked for are left out.
                    let is_there = |name: &str| systems.iter().any(|system| system.name == name);
                    is_there(ordering.system) && is_there(ordering.other)
                })
                .map(|ordering| tested(ordering, results))
                .collect(),
        })
    }
}

impl SystemResult {
    fn trials(&self) -> &[Trial] {
        match self {
            Self::Ran(trials) => trials,
            Self::Missing(_) => &[],
        }
    }
}

impl SystemOutcome {
    /// The mean of a measure.
    pub(crate) fn mean(&self, measure: Measure) -> Option<&Interval> {
        self.means.iter().find(|mean| mean.measure == measure).map(|mean| &mean.value)
    }
}

fn outcome_of(system: &'static System, result: &SystemResult) -> Result<SystemOutcome> {
    let trials = result.trials();
    let mean_of = |measure: Measure| {
        // A measure that one trial lacks has no mean over seeds.
        let values: Option<Vec<f64>> = trials.iter().map(|trial| trial.value(measure)).collect();
        Some(Mean { measure, value: t_interval(&values?)? })
    };
    let times: Option<Vec<f64>> = trials.iter().map(|trial| trial.training_s).collect();
    Ok(SystemOutcome {
        name: system.name,
        about: system.about,
        images: system.images.name(),
        missing: match result {
            SystemResult::Missing(reason) => Some(reason.clone()),
            SystemResult::Ran(trials) => {
                trials.first().context("a system without trials")?;
                None
            }
        },
        means: Measure::ALL.into_iter().filter_map(mean_of).collect(),
        curve: mean_curve(trials.iter().map(|trial| &*trial.curve)),
        training_s: times.and_then(|times| t_interval(&times)),
        published: system
            .published
            .iter()
            .map(|&Figure { measure, data_set, value }| PublishedFigure {
                measure,
                data_set,
                value,
            })
            .collect(),
        per_seed: trials.to_vec(),
    })
}

/// Tests an ordering, seed by seed.
fn tested(ordering: &Ordering, results: &Results) -> TestedOrdering {
    let trials = |name: &str| results.get(name).map_or(&[][..], SystemResult::trials);
    let (here, there) = (trials(ordering.system), trials(ordering.other));
    let differences: Option<Vec<f64>> = here
        .iter()
        .zip(there)
        .map(|(a, b)| Some(a.value(ordering.measure)? - b.value(ordering.measure)?))
        .collect();
    let difference = differences.and_then(|differences| t_interval(&differences));
    // Times of two machines cannot be compared.
    let are_of_one_machine = here.iter().zip(there).all(|(a, b)| a.machine == b.machine);
    let verdict = difference.map(|difference| match ordering.relation {
        Relation::Slower if !are_of_one_machine => Verdict::OtherMachines,
        _ => ordering.verdict(&difference),
    });
    let missing =
        [ordering.system, ordering.other].into_iter().filter(|name| trials(name).is_empty());
    TestedOrdering {
        statement: ordering.statement(),
        measure: ordering.measure,
        difference,
        verdict,
        missing: missing.collect(),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::compare::system::SYSTEMS;
    use crate::compare::trial::tests::trial;

    /// MoveEnet at these PCKs, seed by seed, LiftMono 0.3 below it, OpenPose missing.
    pub(crate) fn outcome(pck: &[f64]) -> Result<Outcome> {
        let trials = |name: &str, offset: f64| {
            pck.iter().zip(1..).map(|(pck, seed)| trial(name, seed, pck - offset)).collect()
        };
        let results = Results::from([
            ("move-enet", SystemResult::Ran(trials("move-enet", 0.0))),
            ("lift-mono", SystemResult::Ran(trials("lift-mono", 0.3))),
            ("openpose-pim", SystemResult::Missing("give --openpose FILE.onnx".to_owned())),
        ]);
        let seeds: Vec<u64> = (1..=pck.len() as u64).collect();
        let systems: Vec<&System> =
            SYSTEMS.iter().filter(|system| results.contains_key(system.name)).collect();
        Outcome::new(&seeds, "people of a test", &systems, &results)
    }

    #[test]
    fn orderings_are_tested_seed_by_seed_where_both_systems_ran() -> Result<()> {
        let outcome = outcome(&[0.8, 0.6, 0.7])?;
        let of = |start: &str| {
            let mut all = outcome.orderings.iter();
            all.find(|ordering| ordering.statement.starts_with(start)).context("an ordering")
        };
        let lift = of("lift-mono worse than move-enet: PCK@0.4 0.28 and 0.97 on DHP19")?;
        assert_eq!(lift.verdict, Some(Verdict::Found));
        // The errors of both are equal in every seed.
        let errors = of("lift-mono worse than move-enet: MPJPE px")?;
        assert_eq!(errors.verdict, Some(Verdict::WithinNoise));
        let pim = of("openpose-pim worse than move-enet: PCK@0.4")?;
        assert_eq!((pim.verdict, pim.missing.as_slice()), (None, &["openpose-pim"][..]));
        assert!(of("dhp19-cnn").is_err(), "not asked for");
        Ok(())
    }

    #[test]
    fn one_seed_decides_nothing() -> Result<()> {
        let outcome = outcome(&[0.8])?;
        assert_eq!(outcome.orderings[0].verdict, None, "{:?}", outcome.orderings[0]);
        let ran = outcome.orderings.iter().filter_map(|ordering| ordering.verdict);
        assert!(ran.clone().count() > 0 && ran.into_iter().all(|v| v == Verdict::OneSeed));
        Ok(())
    }
}
