//! `evpose ablate body`: ablation study of the body method.
//!
//! * [`Stages`]: configs of both stages of the method.
//! * [`Network`], [`networks`]: networks, and their training, several at once.
//! * [`rows`]: the registry of rows and of the test sets.
//! * [`trial`]: one row under one seed, evaluated.
//! * [`outcome`]: means over seeds, compared with the published results; as a table and a page.

mod network;
pub mod networks;
mod outcome;
mod rows;
mod stages;
mod trial;

use std::time::Instant;

use anyhow::Result;

use crate::study::{self, ResultFiles, SeedArgs, StudyArgs};
use evpose_cli::progress::say;
pub use network::Network;
pub use stages::{StageArgs, Stages};

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose ablate body --out runs/ablation-body\n  \
    evpose ablate body --out runs/ablation-body --resume\n  \
    evpose ablate body --rows wo-pretrain,pim --seeds 2 --steps 800 --out runs/two-rows\n\n\
    People are simulated once for each seed and shared by all rows; networks that several rows need are \
    trained once. The full method always runs, since every row is held against it.")]
pub struct AblateBodyArgs {
    #[command(flatten)]
    stages: StageArgs,
    /// Rows to run, comma-separated [default: all]
    #[arg(long, value_delimiter = ',', value_parser = rows::names())]
    rows: Vec<String>,
    #[command(flatten)]
    seeds: SeedArgs,
    /// Concurrent trainings, each with its share of the threads [default: one per thread, at most
    /// 4; 1 on other devices than the CPU]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    #[command(flatten)]
    study: StudyArgs,
}

pub(super) fn run(args: &AblateBodyArgs) -> Result<()> {
    let started = Instant::now();
    let device = args.study.open()?;
    let stages = Stages::load(&args.stages, &args.study.overrides)?;
    study::is_begun(&args.study.out, args.study.resume)?;
    stages.claim(&args.study.out)?;
    let chosen = rows::selected(&args.rows);
    let seeds = args.seeds.all(stages.finetune.seed)?;
    let results = ResultFiles::new(&args.study.out, "ablation");
    args.study.say_place();
    let all: Vec<Stages> = seeds.iter().map(|&seed| stages.with_seed(seed)).collect();
    // All seeds of all rows are trained first, several at once; evaluation is short.
    let at_once = networks::concurrent(args.jobs, args.study.device.device);
    let networks: Vec<Network> = chosen.iter().map(|row| row.network).collect();
    networks::train_all(
        &args.study.out,
        &networks,
        &all,
        (at_once, args.study.device.device),
        None,
    )?;
    let mut trials = outcome::Trials::new();
    for (index, row) in chosen.iter().enumerate() {
        let begun = Instant::now();
        let mut of_row = Vec::new();
        for (stages, seed) in all.iter().zip(&seeds) {
            say(format!("row {}/{}: {}, seed {seed}", index + 1, chosen.len(), row.name));
            let trial = trial::run(&args.study.out, row, stages, &device)?;
            say(format!("    PCK@0.4 {:.3}, PCK@0.8 {:.3}", trial.pck_40, trial.pck_80));
            of_row.push(trial);
        }
        trials.insert(row.name, of_row);
        // After every row, so that an interrupted study has results.
        let outcome = outcome::Outcome::new(&seeds, &chosen, &trials)?;
        let page = outcome::html(&outcome, &stages.to_toml()?)?;
        results.write(&outcome, &outcome::markdown(&outcome), &page)?;
        say(format!("    row done in {:.1} min", begun.elapsed().as_secs_f64() / 60.0));
    }
    say("");
    say(outcome::markdown(&outcome::Outcome::new(&seeds, &chosen, &trials)?));
    results.say_written(started);
    Ok(())
}
