//! The loop of a search: rung after rung, the trials of this process.

use std::path::PathBuf;

use anyhow::{Context, Result, anyhow};
use evpose_cli::bad_input::BadInput;
use evpose_cli::progress::{say, training_bar};
use evpose_cli::run_info::{CONFIG, claim_origin};
use evpose_task::BEST;
use evpose_train::{TrainError, TrainOptions};

use crate::study::{
    Study, StudyDirectory, StudyPlan, TrialIndex, Trials, Written, options, simulate,
};
use crate::tune::args::{TuneArgs, TuneMethod};
use crate::tune::outcome::SearchOutcome;
use crate::tune::plan::{TrialPlan, promoted};
use crate::tune::report;
use crate::tune::rung_result::{RungResult, TrialStatus};
use crate::tune::space::SearchSpace;
use crate::tune::trials::TrialConfigs;

/// Runs `evpose tune`.
///
/// # Errors
/// If the config or the ranges make no sense, the data cannot be read, a training fails other than
/// by diverging, or `--out` holds another search.
pub fn run(args: &TuneArgs) -> Result<()> {
    args.study.open()?;
    let space = SearchSpace::load(&args.over)?;
    let configs = TrialConfigs::new(args, &space)?;
    let higher_is_better = configs.rank(&args.rank)?;
    let length = configs.base.length();
    let plan = match args.method {
        TuneMethod::Random => TrialPlan::random(args.trials, length),
        TuneMethod::Halving => TrialPlan::halving(args.trials, args.eta, args.rungs, length)?,
    };
    // Before anything is trained.
    for trial in 0..args.trials {
        configs.trial(trial)?;
    }
    // Before anything is written.
    if let Some(data) = args.data.as_ref().filter(|data| !data.exists()) {
        return Err(anyhow!("{}: no such directory", data.display()).context(BadInput));
    }
    let inputs = [
        // The plan is an input: with other rungs, the same files would mean other results.
        ("tune.toml", settings(args, &plan)),
        ("over.toml", space.text().to_owned()),
        (CONFIG, configs.base.to_toml()?),
    ];
    let (directory, seed) = (args.study.directory(), configs.base.seed());
    directory.claim(&args.study, seed, &inputs, (0..args.trials).map(trial_path))?;
    // Trials of two builds may differ in more than their parameters.
    claim_origin(directory.root(), seed)?;
    args.study.say_location();
    say(format!("network: {}", configs.base.description()));
    plan.description().iter().for_each(|line| say(format!("plan:    {line}")));
    let data = args.data.clone().unwrap_or_else(|| directory.path("data"));
    if args.data.is_none() && configs.base.trains_on_recordings() {
        simulate(&*configs.base, &data, "simulating")?;
    }
    let (space, configs, plan) = (&space, &configs, &plan);
    Search { args, space, configs, directory, plan, higher_is_better, data }.run()
}

const BEST_CONFIG: &str = "best.toml";

fn trial_path(trial: u64) -> String {
    format!("trials/{trial:04}")
}

fn settings(args: &TuneArgs, plan: &TrialPlan) -> String {
    let mut text = format!("trials = {}\nrank = \"{}\"\n", args.trials, args.rank);
    for (index, rung) in plan.rungs().iter().enumerate() {
        let (trials, steps) = (rung.trials, plan.steps_of(index));
        text += &format!("\n[[rung]]\ntrials = {trials}\nsteps = {steps}\n");
    }
    text
}

struct Search<'a> {
    args: &'a TuneArgs,
    space: &'a SearchSpace,
    configs: &'a TrialConfigs<'a>,
    directory: StudyDirectory,
    plan: &'a TrialPlan,
    higher_is_better: bool,
    data: PathBuf,
}

impl Search<'_> {
    fn run(&self) -> Result<()> {
        for rung in 0..self.plan.rungs().len() {
            // Results of other shards are missing: a later start goes on.
            let Some(trials) = self.entrants(rung)? else { return Ok(()) };
            let name = |&trial: &u64| format!("trial {trial}: {}", self.configs.description(trial));
            let plan = StudyPlan {
                args: &self.args.study,
                seed: self.configs.base.seed(),
                inputs: Vec::new(),
                rows: trials.iter().map(name).collect(),
                seeds: vec![format!("rung {}", rung + 1)],
                files: ["tune.json", "tune.md", "tune.html"],
            };
            plan.finish(&RungStudy { search: self, rung, trials: &trials })?;
            self.release(&trials, rung)?;
        }
        let best = self.directory.path(BEST_CONFIG);
        if best.exists() {
            say(format!("the best trial, as a config: {}", best.display()));
        }
        Ok(())
    }

    fn run_of(&self, trial: u64) -> PathBuf {
        self.directory.path(&trial_path(trial)).join("run")
    }

    /// The result of a trial at the end of a rung; none while there is none.
    fn result(&self, trial: u64, rung: usize) -> Result<Option<RungResult>> {
        self.directory.result(&result_path(trial, rung))
    }

    /// The trials of a rung. None while a trial of the rung before it has no result.
    fn entrants(&self, rung: usize) -> Result<Option<Vec<u64>>> {
        // They follow from stored results alone, so that all shards come to the same trials.
        let mut entrants: Vec<u64> = (0..self.args.trials).collect();
        for before in 0..rung {
            let mut scored = Vec::new();
            for &trial in &entrants {
                let Some(result) = self.result(trial, before)? else { return Ok(None) };
                scored.push((trial, result.score(&self.args.rank)));
            }
            let places = self.plan.rungs()[before + 1].trials;
            entrants = promoted(scored, places, self.higher_is_better);
        }
        Ok(Some(entrants))
    }

    /// Removes the checkpoints of trials that no rung continues, once a rung is complete: those of an optimiser are
    /// several times as large as its network.
    fn release(&self, trials: &[u64], rung: usize) -> Result<()> {
        let is_last = rung + 1 == self.plan.rungs().len();
        let next = if is_last { Some(Vec::new()) } else { self.entrants(rung + 1)? };
        let Some(next) = next else { return Ok(()) };
        for &trial in trials.iter().filter(|trial| !next.contains(trial)) {
            let path = self.run_of(trial).join("checkpoint");
            // Unless its shard is still at it.
            if self.result(trial, rung)?.is_none() {
                continue;
            }
            match std::fs::remove_dir_all(&path) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                    return Err(error).with_context(|| format!("removing {}", path.display()));
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn outcome(&self) -> Result<SearchOutcome> {
        let mut by_rung = Vec::new();
        for rung in 0..self.plan.rungs().len() {
            // The entrants of later rungs follow from results that are still missing.
            let Some(entrants) = self.entrants(rung)? else { break };
            let mut results = Vec::new();
            for trial in entrants {
                results.push((trial, self.result(trial, rung)?));
            }
            by_rung.push(results);
        }
        let experiment = &self.configs.base;
        let mut outcome = SearchOutcome {
            schema: SCHEMA,
            task: self.configs.task.name(),
            network: experiment.description(),
            seed: experiment.seed(),
            method: self.args.method,
            rank: self.args.rank.clone(),
            higher_is_better: self.higher_is_better,
            logged: experiment.logged_values().iter().map(|value| value.name).collect(),
            parameters: self.space.parameters().iter().map(|p| p.field.clone()).collect(),
            rungs: (0..self.plan.rungs().len()).map(|rung| self.plan.steps_of(rung)).collect(),
            count: self.args.trials,
            is_complete: false,
            trials: Vec::new(),
        };
        outcome.fill(&by_rung, |trial| self.configs.values(trial));
        Ok(outcome)
    }
}

struct RungStudy<'a> {
    search: &'a Search<'a>,
    rung: usize,
    trials: &'a [u64],
}

impl Study for RungStudy<'_> {
    type Trial = RungResult;
    type Outcome = SearchOutcome;

    fn path(&self, (row, _): TrialIndex) -> String {
        result_path(self.trials[row], self.rung)
    }

    /// Trains a trial until the end of the rung.
    fn run(&self, (row, _): TrialIndex) -> Result<(RungResult, String)> {
        let (search, trial) = (self.search, self.trials[row]);
        let experiment = search.configs.trial(trial)?;
        let run = search.run_of(trial);
        let (progress, callback) = training_bar(&format!("trial {trial}"));
        let options = TrainOptions {
            pause_after: search.plan.rungs()[self.rung].pause_after,
            ..options(search.args.study.device.device, callback)
        };
        let trained = experiment.train(&search.data, &run, &options);
        progress.finish_and_clear();
        let status = match trained {
            // Only a training that came to its end has chosen its best network.
            Ok(()) if run.join(BEST).exists() => TrialStatus::Trained,
            Ok(()) => TrialStatus::Paused,
            Err(error) => match error.downcast_ref::<TrainError>() {
                // Divergence is a result, every other error ends the search.
                Some(TrainError::Diverged { .. }) => TrialStatus::Diverged,
                _ => return Err(error),
            },
        };
        let logged = experiment.logged_values();
        let result = RungResult::of_run(&run, status, experiment.length(), logged)?;
        let rank = &search.args.rank;
        let line = match (result.score(rank), result.best()) {
            (Some(score), Some(best)) => {
                format!("{rank} {score:.4} at step {}, {}", best.step, status.name())
            }
            _ => status.name().to_owned(),
        };
        Ok((result, line))
    }

    fn outcome(&self, _: &Trials<RungResult>) -> Result<Written<SearchOutcome>> {
        let search = self.search;
        let outcome = search.outcome()?;
        search.directory.write("trials.csv", &outcome.csv())?;
        if let Some(best) = outcome.best() {
            let config = search.configs.trial(best.trial)?.to_toml()?;
            search.directory.write(BEST_CONFIG, &(outcome.heading() + &config))?;
        }
        let report = report::report(&outcome, search.space, search.configs.base.to_toml()?)?;
        Ok(Some((outcome, report)))
    }
}

fn result_path(trial: u64, rung: usize) -> String {
    format!("{}/rung-{}.json", trial_path(trial), rung + 1)
}

/// Version of the layout of `tune.json`.
const SCHEMA: u32 = 1;
