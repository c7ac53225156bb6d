//! The loop of a search: rung after rung, the trials of this process.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, anyhow};
use evpose_cli::bad_input::BadInput;
use evpose_cli::progress::{say, training_bar};
use evpose_sim::Shard;
use evpose_task::BEST;
use evpose_train::{TrainError, TrainOptions};

use crate::tune::args::{TuneArgs, TuneMethod};
use crate::tune::directory::SearchDirectory;
use crate::tune::outcome::SearchOutcome;
use crate::tune::page;
use crate::tune::plan::TrialPlan;
use crate::tune::ranking::promoted;
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
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    check_data(args, &configs, shard)?;
    let config = configs.base.to_toml()?;
    let settings = settings(args, &plan);
    let texts = [config.as_str(), space.text(), &settings];
    let seed = configs.base.seed();
    let directory =
        SearchDirectory::open(&args.study.out, seed, texts, shard, args.trials, args.study.resume)?;
    args.study.say_place();
    say(format!("network: {}", configs.base.description()));
    plan.description().iter().for_each(|line| say(format!("plan:    {line}")));
    let data = data(args, &configs, &directory)?;
    let mut search = Search {
        args,
        space: &space,
        configs: &configs,
        directory: &directory,
        plan: &plan,
        higher_is_better,
        shard,
        data: &data,
        started: Instant::now(),
        steps: 0,
    };
    search.run()
}

/// The plan as TOML.
fn settings(args: &TuneArgs, plan: &TrialPlan) -> String {
    let mut text = format!("trials = {}\nrank = \"{}\"\n", args.trials, args.rank);
    for (index, rung) in plan.rungs().iter().enumerate() {
        let (trials, steps) = (rung.trials, plan.steps_of(index));
        text += &format!("\n[[rung]]\ntrials = {trials}\nsteps = {steps}\n");
    }
    text
}

/// Refuses data that are not there, before anything is written.
fn check_data(args: &TuneArgs, configs: &TrialConfigs<'_>, shard: Shard) -> Result<()> {
    let problem = match &args.data {
        Some(data) if !data.exists() => format!("{}: no such directory", data.display()),
        None if configs.base.trains_on_recordings() && !shard.is_whole() => {
            "--shard needs --data, recordings that all shards share: `evpose simulate CONFIG --out \
             DIR` makes them"
                .to_owned()
        }
        _ => return Ok(()),
    };
    Err(anyhow!(problem).context(BadInput))
}

/// The training data, simulated where they are missing.
fn data(
    args: &TuneArgs,
    configs: &TrialConfigs<'_>,
    directory: &SearchDirectory<'_>,
) -> Result<PathBuf> {
    if let Some(data) = &args.data {
        return Ok(data.clone());
    }
    let data = directory.data();
    if configs.base.trains_on_recordings() {
        say(format!("data:    {}", configs.base.simulate(&data, "simulating")?));
    }
    Ok(data)
}

/// A search in this process.
struct Search<'a> {
    args: &'a TuneArgs,
    space: &'a SearchSpace,
    configs: &'a TrialConfigs<'a>,
    directory: &'a SearchDirectory<'a>,
    plan: &'a TrialPlan,
    higher_is_better: bool,
    shard: Shard,
    data: &'a Path,
    started: Instant,
    /// Optimiser steps of trials that this process finished.
    steps: u64,
}

impl Search<'_> {
    fn run(&mut self) -> Result<()> {
        for rung in 0..self.plan.rungs().len() {
            // Results of other shards are missing: a later start goes on.
            let Some(trials) = self.entrants(rung)? else { return self.end() };
            let ours: Vec<u64> =
                trials.iter().copied().filter(|&trial| self.shard.owns(trial)).collect();
            for (index, &trial) in ours.iter().enumerate() {
                if self.directory.result(trial, rung)?.is_none() {
                    let place = format!("rung {}, {} of {}", rung + 1, index + 1, ours.len());
                    self.train(trial, rung, &place)?;
                    // After every trial, so that an interrupted search has its results.
                    self.write()?;
                }
            }
            self.release(&trials, rung)?;
        }
        self.end()
    }

    /// The trials of a rung. None while a trial of the rung before it has no result.
    fn entrants(&self, rung: usize) -> Result<Option<Vec<u64>>> {
        let mut entrants: Vec<u64> = (0..self.args.trials).collect();
        for before in 0..rung {
            let mut scored = Vec::new();
            for &trial in &entrants {
                let Some(result) = self.directory.result(trial, before)? else { return Ok(None) };
                scored.push((trial, result.score(&self.args.rank)));
            }
            let places = self.plan.rungs()[before + 1].trials;
            entrants = promoted(scored, places, self.higher_is_better);
        }
        Ok(Some(entrants))
    }

    /// Trains a trial until the end of a rung, and writes its result.
    fn train(&mut self, trial: u64, rung: usize, place: &str) -> Result<()> {
        say(format!("{place}: trial {trial}: {}", self.configs.description(trial)));
        let experiment = self.configs.trial(trial)?;
        let run = self.directory.run(trial);
        let (progress, callback) = training_bar(&format!("trial {trial}"));
        let options = TrainOptions {
            device: self.args.study.device.device,
            resume: true,
            plain: true,
            progress: Some(callback),
            pause_after: self.plan.rungs()[rung].pause_after,
        };
        let trained = experiment.train(self.data, &run, &options);
        progress.finish_and_clear();
        let status = match trained {
            // Only a training that came to its end has chosen its best network.
            Ok(()) if run.join(BEST).exists() => TrialStatus::Trained,
            Ok(()) => TrialStatus::Paused,
            Err(error) => match error.downcast_ref::<TrainError>() {
                // Divergence is a result, every other error ends the search.
                Some(TrainError::Diverged { .. }) => TrialStatus::Diverged,
                _ => return Err(error).with_context(|| format!("trial {trial}")),
            },
        };
        let logged = experiment.logged_values();
        let result = RungResult::of_run(&run, status, experiment.length(), logged)?;
        self.directory.write_result(trial, rung, &result)?;
        self.steps += self.plan.added_steps(rung);
        say(format!("    {}", self.line(&result)));
        Ok(())
    }

    /// The result of a trial, and the time that is left.
    fn line(&self, result: &RungResult) -> String {
        let rank = &self.args.rank;
        let mut line = match (result.score(rank), result.best()) {
            (Some(score), Some(best)) => {
                format!("{rank} {score:.4} at step {}, {}", best.step, result.status.name())
            }
            _ => result.status.name().to_owned(),
        };
        // This process trains its shard alone.
        let share =
            self.shard.sequences_of(self.args.trials).count() as f64 / self.args.trials as f64;
        let total = share * self.plan.total_steps() as f64;
        let elapsed = self.started.elapsed().as_secs_f64();
        let left = elapsed / self.steps as f64 * (total - self.steps as f64);
        if left > 0.0 {
            line += &format!("; at most {:.0} min to go", (left / 60.0).ceil());
        }
        line
    }

    /// Removes the checkpoints of this process's trials that no rung continues, once a rung is
    /// complete.
    fn release(&self, trials: &[u64], rung: usize) -> Result<()> {
        let is_last = rung + 1 == self.plan.rungs().len();
        let next = if is_last { Some(Vec::new()) } else { self.entrants(rung + 1)? };
        let Some(next) = next else { return Ok(()) };
        let over = trials.iter().filter(|trial| !next.contains(trial));
        over.filter(|trial| self.shard.owns(**trial))
            .try_for_each(|&trial| self.directory.remove_checkpoints(trial))
    }

    fn outcome(&self) -> Result<SearchOutcome> {
        let mut by_rung = Vec::new();
        for rung in 0..self.plan.rungs().len() {
            let Some(entrants) = self.entrants(rung)? else { break };
            let mut results = Vec::new();
            for trial in entrants {
                results.push((trial, self.directory.result(trial, rung)?));
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

    /// Writes the results of what is finished. Of several processes the one that writes last has
    /// seen all of it, and if two write at once each sees what came in between.
    fn write(&self) -> Result<SearchOutcome> {
        let mut outcome = self.outcome()?;
        loop {
            self.directory.write(JSON, &(serde_json::to_string_pretty(&outcome)? + "\n"))?;
            self.directory.write(CSV, &outcome.csv())?;
            let html = page::html(&outcome, self.space, &self.configs.base.to_toml()?)?;
            self.directory.write(PAGE, &html)?;
            if let Some(best) = outcome.best() {
                let config = self.configs.trial(best.trial)?.to_toml()?;
                self.directory.write(BEST_CONFIG, &(outcome.heading() + &config))?;
            }
            let now = self.outcome()?;
            if now == outcome {
                return Ok(outcome);
            }
            outcome = now;
        }
    }

    /// Says what came of it.
    fn end(&self) -> Result<()> {
        let outcome = self.write()?;
        say("");
        outcome.lines().iter().for_each(say);
        say("");
        if !outcome.is_complete {
            say(
                "trials of other shards are not finished: start the shards again with --resume for \
                 the next rung",
            );
        }
        for name in [PAGE, JSON, CSV, BEST_CONFIG] {
            if self.directory.path(name).exists() {
                say(format!("written: {}", self.directory.path(name).display()));
            }
        }
        Ok(())
    }
}

/// Version of the layout of `tune.json`.
const SCHEMA: u32 = 1;
/// Files of results.
const JSON: &str = "tune.json";
const CSV: &str = "trials.csv";
const PAGE: &str = "tune.html";
const BEST_CONFIG: &str = "best.toml";
