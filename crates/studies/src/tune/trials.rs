//! The configs of the trials, all checked before the first is trained.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use evpose_cli::args::ConfigArgs;
use evpose_cli::shipped::checkpoint_path;
use evpose_cli::tasks::{PoseExperiment, PoseTask, StartWeights, experiment};
use evpose_train::LOSS;
use toml::Value;

use crate::tune::args::{TuneArgs, TuneMethod};
use crate::tune::space::{Parameter, SearchSpace, inline};

/// Fields, or sections of them, that a search cannot be over, and the reason.
const FIXED: [(&str, &str); 10] = [
    ("task", "says which networks are searched"),
    ("seed", "is shared by all trials, so that nothing but the parameters differs"),
    ("out", "is a directory, not a parameter"),
    ("start_from", "is no parameter: give --start-from"),
    ("simulation", "trials share their recordings: simulate others into a --data of their own"),
    ("evaluation", "changes no training"),
    ("training.validation_s", VALIDATION),
    ("training.validation_samples", VALIDATION),
    ("data.validation_share", VALIDATION),
    ("data.stills", VALIDATION),
];
const VALIDATION: &str = "trials are compared on the same validation data";
/// Sections whose fields scale the loss.
const SCALES: [&str; 2] = ["loss", "targets"];

fn is_in(field: &str, section: &str) -> bool {
    field.strip_prefix(section).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// The experiments of a search.
pub(crate) struct TrialConfigs<'a> {
    config: ConfigArgs,
    start_from: Option<PathBuf>,
    space: &'a SearchSpace,
    /// The config as it is: trial 0.
    pub(crate) base: Box<dyn PoseExperiment>,
    pub(crate) task: &'static dyn PoseTask,
    base_values: toml::Table,
}

impl<'a> TrialConfigs<'a> {
    /// Reads the config and checks that the space is one of it.
    pub(crate) fn new(args: &'a TuneArgs, space: &'a SearchSpace) -> Result<Self> {
        let start_from = args.start_from.as_deref().map(checkpoint_path).transpose()?;
        let config = args.study.config(&args.config);
        let (task, base) = experiment(&config, start_of(start_from.as_deref()))?;
        // TOML is the way to a field that is known by its dotted name alone.
        let base_values = toml::from_str(&base.to_toml()?).context("the config as TOML")?;
        let configs = Self { config, start_from, space, base, task, base_values };
        for parameter in space.parameters() {
            configs.check(parameter, args)?;
        }
        Ok(configs)
    }

    fn check(&self, parameter: &Parameter, args: &TuneArgs) -> Result<()> {
        let refuse = |message: &str| Err(self.space.refuse(parameter, message));
        let field = parameter.field.as_str();
        if let Some((_, why)) = FIXED.iter().find(|(fixed, _)| is_in(field, fixed)) {
            return refuse(why);
        }
        let is_length = ["training.steps", "training.steps_per_validation"].contains(&field);
        if is_length && args.method == TuneMethod::Halving {
            return refuse(
                "halving decides how long trials are trained: leave it to the config, or take \
                 --method random",
            );
        }
        // A scale that is searched changes what the loss means.
        if args.rank == LOSS && SCALES.iter().any(|section| is_in(field, section)) {
            let values = self.base.logged_values();
            let others: Vec<&str> = values.iter().map(|v| v.name).filter(|n| *n != LOSS).collect();
            return refuse(&format!(
                "losses that are scaled otherwise cannot be compared: rank by another value, --rank {}",
                others.join(", ")
            ));
        }
        // Ends of ranges are tried, so that no trial fails after hours.
        for value in parameter.distribution.extremes() {
            let overrides = vec![format!("{field}={}", inline(&value))];
            if let Err(error) = self.experiment(overrides) {
                return refuse(&format!("{}: {error:#}", inline(&value)));
            }
        }
        Ok(())
    }

    fn experiment(&self, mut changes: Vec<String>) -> Result<Box<dyn PoseExperiment>> {
        let mut overrides = self.config.overrides.clone();
        // The last change of a field counts: what is drawn wins over --set.
        overrides.append(&mut changes);
        let args = ConfigArgs { config: self.config.config.clone(), overrides };
        self.task.studied()?.experiment(&args, start_of(self.start_from.as_deref()))
    }

    /// The values of trial `trial`; none where the config does not have the field.
    pub(crate) fn values(&self, trial: u64) -> Vec<Option<Value>> {
        let seed = self.base.seed();
        let value = |parameter: &Parameter| match trial {
            0 => value_of(&self.base_values, &parameter.field),
            _ => Some(parameter.draw(seed, trial)),
        };
        self.space.parameters().iter().map(value).collect()
    }

    pub(crate) fn description(&self, trial: u64) -> String {
        if trial == 0 {
            return "the config as it is".to_owned();
        }
        self.changes(trial).join(", ")
    }

    /// The values of trial `trial` as `--set` takes them.
    fn changes(&self, trial: u64) -> Vec<String> {
        let parameters = self.space.parameters().iter().zip(self.values(trial));
        let change = |(parameter, value): (&Parameter, Option<Value>)| {
            Some(format!("{} = {}", parameter.field, inline(&value?)))
        };
        parameters.filter_map(change).collect()
    }

    pub(crate) fn trial(&self, trial: u64) -> Result<Box<dyn PoseExperiment>> {
        let changes = if trial == 0 { Vec::new() } else { self.changes(trial) };
        self.experiment(changes).with_context(|| {
            format!("trial {trial} ({}): narrow the ranges of --over", self.description(trial))
        })
    }

    /// Checks the value that trials are ranked by; returns whether more of it is better.
    pub(crate) fn rank(&self, name: &str) -> Result<bool> {
        let values = self.base.logged_values();
        let value = values.iter().find(|value| value.name == name).with_context(|| {
            let known: Vec<&str> = values.iter().map(|value| value.name).collect();
            let (task, known) = (self.task.name(), known.join(", "));
            format!("--rank {name}: trainings of the task `{task}` log {known}")
        })?;
        Ok(value.higher_is_better)
    }
}

/// The weights of the argument, or else those of the config.
fn start_of(run: Option<&Path>) -> StartWeights<'_> {
    run.map_or(StartWeights::OfConfig, StartWeights::Run)
}

fn value_of(table: &toml::Table, field: &str) -> Option<Value> {
    match field.split_once('.') {
        None => table.get(field).cloned(),
        Some((section, rest)) => value_of(table.get(section)?.as_table()?, rest),
    }
}
