//! `evpose ablate body`: ablation study of the body method.
//!
//! * [`rows`]: the registry of rows, of the networks that they need, and of the test sets.
//! * [`networks`]: training of the required networks, several at once.
//! * [`trial`]: one row under one seed, evaluated.
//! * [`outcome`]: means over seeds, compared with the published results; as a table and a page.

mod networks;
mod outcome;
mod rows;
mod trial;

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use evpose_core::atomic_write;
use evpose_nn::DeviceKind;
use evpose_task::body::BodyConfig;

use super::directories::write;
use evpose_app::args::ConfigArgs;
use evpose_app::args::DeviceArgs;
use evpose_app::body_config;
use evpose_app::machine::Machine;
use evpose_app::progress::say;
use evpose_app::run_info;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose ablate body --out runs/ablation-body\n  \
    evpose ablate body --out runs/ablation-body --resume\n  \
    evpose ablate body --rows wo-pretrain,pim --seeds 2 --steps 800 --out runs/two-rows\n\n\
    People are simulated once for each seed and shared by all rows; networks that several rows need are \
    trained once. The full method always runs, since every row is held against it.")]
pub struct AblateBodyArgs {
    /// The first stage: a TOML file, or an embedded config
    #[arg(long, default_value = "pretrain")]
    pretrain: String,
    /// The second stage: a TOML file, or an embedded config
    #[arg(long, default_value = "finetune")]
    finetune: String,
    /// Change one field of both stages, for example --set training.batch_size=16 (may be repeated)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Optimiser steps of every training, instead of the configs'
    #[arg(long, default_value_t = 1_500, value_parser = clap::value_parser!(u64).range(1..))]
    steps: u64,
    /// Rows to run, comma-separated [default: all]
    #[arg(long, value_delimiter = ',', value_parser = rows::names())]
    rows: Vec<String>,
    /// Number of seeds, from that of the config on: intervals are over seeds
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=100))]
    seeds: u64,
    /// Concurrent trainings, each with its share of the threads [default: one per thread, at most
    /// 4; 1 on other devices than the CPU]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Directory for data, trainings, the table and the page
    #[arg(long, default_value = "runs/ablation-body")]
    out: PathBuf,
    /// Continue an interrupted study in the directory
    #[arg(long)]
    resume: bool,
    #[command(flatten)]
    device: DeviceArgs,
}

/// Both stages of the full method.
#[derive(Debug, Clone)]
struct Stages {
    pretrain: BodyConfig,
    finetune: BodyConfig,
}

impl Stages {
    fn load(args: &AblateBodyArgs) -> Result<Self> {
        let load = |config: &str| -> Result<BodyConfig> {
            let given = ConfigArgs { config: config.to_owned(), overrides: args.overrides.clone() };
            let mut config = body_config::config(&given)?
                .with_context(|| format!("{config}: no config of bodies"))?;
            config.training.steps = args.steps;
            config.training.steps_per_validation =
                config.training.steps_per_validation.min(args.steps);
            // Evaluated at the rate of the training labels.
            config.evaluation.every_ms = config.data.every_ms;
            Ok(config)
        };
        let (pretrain, finetune) = (load(&args.pretrain)?, load(&args.finetune)?);
        if pretrain.network != finetune.network || pretrain.image.side_px != finetune.image.side_px
        {
            bail!("both stages must have the same [network] and image.side_px");
        }
        Ok(Self { pretrain, finetune })
    }

    fn with_seed(&self, seed: u64) -> Self {
        let of = |config: &BodyConfig| BodyConfig { seed, ..config.clone() };
        Self { pretrain: of(&self.pretrain), finetune: of(&self.finetune) }
    }
}

pub(super) fn run(args: &AblateBodyArgs) -> Result<()> {
    evpose_kernels::keep_freed_memory();
    let started = Instant::now();
    let device = args.device.open()?;
    let stages = Stages::load(args)?;
    if args.out.read_dir().is_ok_and(|mut entries| entries.next().is_some()) && !args.resume {
        bail!("{} is not empty: add --resume, or choose another --out", args.out.display());
    }
    claim(args, &stages)?;
    let chosen = rows::selected(&args.rows);
    let seeds: Vec<u64> = (0..args.seeds).map(|i| stages.finetune.seed.saturating_add(i)).collect();
    say(format!("machine: {}", Machine::this()));
    say(format!("output:  {}", args.out.display()));
    let all: Vec<Stages> = seeds.iter().map(|&seed| stages.with_seed(seed)).collect();
    let at_once = match (args.jobs, args.device.device) {
        (Some(jobs), _) => usize::from(jobs),
        (None, DeviceKind::Flex) => rayon::current_num_threads().min(4),
        (None, _) => 1,
    };
    networks::train_all(&args.out, &chosen, &all, at_once, args.device.device)?;
    let mut trials = outcome::Trials::new();
    for (index, row) in chosen.iter().enumerate() {
        let begun = Instant::now();
        let mut of_row = Vec::new();
        for (stages, seed) in all.iter().zip(&seeds) {
            say(format!("row {}/{}: {}, seed {seed}", index + 1, chosen.len(), row.name));
            let trial = trial::run(&args.out, row, stages, &device)?;
            say(format!("    PCK@0.4 {:.3}, PCK@0.8 {:.3}", trial.pck_40, trial.pck_80));
            of_row.push(trial);
        }
        trials.insert(row.name, of_row);
        // After every row, so that an interrupted study has results.
        report(args, &stages, &seeds, &chosen, &trials)?;
        say(format!("    row done in {:.1} min", begun.elapsed().as_secs_f64() / 60.0));
    }
    say("");
    say(outcome::markdown(&outcome::Outcome::new(&seeds, &chosen, &trials)?));
    say(format!("done in {:.1} minutes", started.elapsed().as_secs_f64() / 60.0));
    for name in RESULTS {
        say(format!("written: {}", args.out.join(name).display()));
    }
    Ok(())
}

/// Files of results: values, table, page.
const RESULTS: [&str; 3] = ["ablation.json", "ablation.md", "ablation.html"];

fn report(
    args: &AblateBodyArgs,
    stages: &Stages,
    seeds: &[u64],
    rows: &[&'static rows::Row],
    trials: &outcome::Trials,
) -> Result<()> {
    let outcome = outcome::Outcome::new(seeds, rows, trials)?;
    let [json, markdown, html] = RESULTS.map(|name| args.out.join(name));
    write(&json, &outcome)?;
    let configs = format!("{}\n{}", stages.pretrain.to_toml()?, stages.finetune.to_toml()?);
    let texts =
        [(markdown, outcome::markdown(&outcome)), (html, outcome::html(&outcome, &configs)?)];
    for (path, text) in texts {
        atomic_write(&path, text.as_bytes())
            .with_context(|| format!("writing {}", path.display()))?;
    }
    Ok(())
}

/// Claims the directory for these stages.
fn claim(args: &AblateBodyArgs, stages: &Stages) -> Result<()> {
    for (name, config) in [("pretrain.toml", &stages.pretrain), ("finetune.toml", &stages.finetune)]
    {
        let path = args.out.join(name);
        if path.exists() {
            let there = BodyConfig::read(&path)?;
            let fields = config.differences(&there)?;
            if !fields.is_empty() {
                return Err(evpose_train::TrainError::ConfigDiffers { path, fields }.into());
            }
        } else {
            std::fs::create_dir_all(&args.out)
                .with_context(|| format!("creating {}", args.out.display()))?;
            atomic_write(&path, config.to_toml()?.as_bytes())
                .with_context(|| format!("writing {}", path.display()))?;
        }
    }
    if args.out.join("run.toml").exists() {
        return Ok(());
    }
    run_info::write(&args.out, stages.finetune.seed, None)
}
