//! `evpose compare body`: all systems under all seeds.

use std::path::Path;
use std::time::Instant;

use crate::ablate::{Network, Stages, networks};
use anyhow::{Context, Result, bail};
use evpose_cli::progress::say;

use crate::compare::args::CompareBodyArgs;
use crate::compare::baselines;
use crate::compare::data::Data;
use crate::compare::outcome::{Outcome, Results, SystemResult};
use crate::compare::predictor::ReadySystem;
use crate::compare::system::{FileKind, System, Weights, selected};
use crate::compare::trial::{self, Candidate};
use crate::compare::{page, table};
use crate::study::{self, ResultFiles};

/// Trains, evaluates and writes what is missing.
pub(crate) fn run(args: &CompareBodyArgs) -> Result<()> {
    let started = Instant::now();
    args.study.open()?;
    let data = Data::new(args)?;
    let stages = data.stages(Stages::load(&args.stages, &args.study.overrides)?);
    let chosen = selected(&args.systems);
    // Before anything is simulated or trained.
    let missing = missing(args, &data, &chosen)?;
    study::is_begun(&args.study.out, args.study.resume)?;
    stages.claim(&args.study.out)?;
    data.claim(&args.study.out)?;
    let seeds = args.seeds.all(stages.finetune.seed)?;
    let files = ResultFiles::new(&args.study.out, "comparison");
    let configs = stages.to_toml()?;
    let write = |outcome: &Outcome| {
        files.write(outcome, &table::markdown(outcome), &page::html(outcome, &configs)?)
    };
    let all: Vec<Stages> = seeds.iter().map(|&seed| stages.with_seed(seed)).collect();
    args.study.say_place();
    let mut results = Results::new();
    for (name, reason) in missing {
        say(format!("{name} does not run: {reason}"));
        results.insert(name, SystemResult::Missing(reason));
    }
    let runs: Vec<&'static System> =
        chosen.iter().copied().filter(|system| !results.contains_key(system.name)).collect();
    train(args, &data, &runs, &all)?;
    for (index, system) in runs.iter().enumerate() {
        let candidate = Candidate { system, file: file_of(args, system) };
        let mut trials = Vec::new();
        for (stages, seed) in all.iter().zip(&seeds) {
            say(format!("system {}/{}: {}, seed {seed}", index + 1, runs.len(), system.name));
            let trial = trial::run(&args.study.out, &data, &candidate, stages)
                .with_context(|| format!("evaluating {}, seed {seed}", system.name))?;
            say(format!("    PCK@0.4 {:.3}, PCK@0.8 {:.3}", trial.pck[0], trial.pck[2]));
            trials.push(trial);
        }
        results.insert(system.name, SystemResult::Ran(trials));
        // After every system, so that an interrupted comparison has results.
        write(&Outcome::new(&seeds, &words(&data), &chosen, &results)?)?;
    }
    let outcome = Outcome::new(&seeds, &words(&data), &chosen, &results)?;
    write(&outcome)?;
    say("");
    say(table::markdown(&outcome));
    files.say_written(started);
    Ok(())
}

/// Trains what is trained here.
fn train(
    args: &CompareBodyArgs,
    data: &Data,
    systems: &[&'static System],
    all: &[Stages],
) -> Result<()> {
    let device = args.study.device.device;
    let of_move_enet: Vec<Network> = systems.iter().filter_map(|system| system.network()).collect();
    if !of_move_enet.is_empty() {
        let jobs = networks::concurrent(args.jobs, device);
        networks::train_all(
            &args.study.out,
            &of_move_enet,
            all,
            (jobs, device),
            data.given_train(),
        )?;
    }
    for system in systems {
        // One after the other: each uses all threads.
        if let Weights::Baseline(kind) = system.weights {
            for stages in all {
                baselines::train((system.name, kind), &args.study.out, data, stages, device)?;
            }
        }
    }
    Ok(())
}

/// Systems that cannot be run, and why. A file that cannot be opened is an error.
fn missing(
    args: &CompareBodyArgs,
    data: &Data,
    systems: &[&'static System],
) -> Result<Vec<(&'static str, String)>> {
    let mut missing = Vec::new();
    for system in systems {
        let missing_file = match (system.weights, file_of(args, system)) {
            (Weights::File(kind), None) => Some(kind.how_to_get().to_owned()),
            (Weights::File(kind), Some(path)) => {
                // Opened now: a wrong file should not end the study hours later.
                ReadySystem::file(kind, path)?;
                None
            }
            _ => None,
        };
        if let Some(reason) = missing_file.or_else(|| data.missing_input(system)) {
            missing.push((system.name, reason));
        }
    }
    // Some systems may be missing, but not all.
    if missing.len() == systems.len() {
        let reasons: Vec<String> =
            missing.iter().map(|(name, reason)| format!("{name}: {reason}")).collect();
        bail!("no system can be run. {}", reasons.join("; "));
    }
    Ok(missing)
}

/// The file of a system's weights.
fn file_of<'a>(args: &'a CompareBodyArgs, system: &System) -> Option<&'a Path> {
    match system.weights {
        Weights::File(FileKind::OpenPose) => args.openpose.as_deref(),
        Weights::File(FileKind::MoveNet) => args.movenet.as_deref(),
        _ => None,
    }
}

/// The data that systems are evaluated on, in words.
fn words(data: &Data) -> String {
    match data {
        Data::Simulated => "simulated people that are in no training set".to_owned(),
        Data::Given { test, .. } => test.display().to_string(),
    }
}
