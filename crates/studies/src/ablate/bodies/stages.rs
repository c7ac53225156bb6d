//! Both stages of the body method: their configs.

use std::path::Path;

use anyhow::{Context, Result, bail};
use evpose_cli::ranges::within;
use evpose_cli::{configs, run_info};
use evpose_core::atomic_write;
use evpose_task::Experiment as _;
use evpose_task::body::BodyConfig;

/// Arguments of commands that train both stages.
#[derive(Debug, Clone, clap::Args)]
pub struct StageArgs {
    /// The first stage: a TOML file, or an embedded config
    #[arg(long, default_value = "pretrain")]
    pub pretrain: String,
    /// The second stage: a TOML file, or an embedded config
    #[arg(long, default_value = "finetune")]
    pub finetune: String,
    /// Optimiser steps of every training, instead of the configs'
    #[arg(long, default_value_t = 1_500, value_parser = within(1..=1_000_000_000_u64))]
    pub steps: u64,
}

/// Configs of both stages of the full method.
#[derive(Debug, Clone)]
pub struct Stages {
    /// On stills.
    pub pretrain: BodyConfig,
    /// On recordings.
    pub finetune: BodyConfig,
}

impl Stages {
    /// Loads both configs.
    ///
    /// # Errors
    /// If one cannot be read, or they are of different networks.
    pub fn load(args: &StageArgs, overrides: &[String]) -> Result<Self> {
        let load = |config: &str| -> Result<BodyConfig> {
            let mut config: BodyConfig = configs::load(config, overrides)?;
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

    /// Both under a seed.
    #[must_use]
    pub fn with_seed(&self, seed: u64) -> Self {
        let of = |config: &BodyConfig| BodyConfig { seed, ..config.clone() };
        Self { pretrain: of(&self.pretrain), finetune: of(&self.finetune) }
    }

    /// Claims the directory of a study for these stages: writes their configs and `run.toml`.
    ///
    /// # Errors
    /// If the directory is of other configs, or cannot be written.
    pub fn claim(&self, out: &Path) -> Result<()> {
        for (name, config) in [("pretrain.toml", &self.pretrain), ("finetune.toml", &self.finetune)]
        {
            let path = out.join(name);
            // Networks of an earlier run in this directory have to be of the same configs.
            if path.exists() {
                let there = BodyConfig::read(&path)?;
                let fields = config.differences(&there)?;
                if !fields.is_empty() {
                    return Err(evpose_train::TrainError::ConfigDiffers { path, fields }.into());
                }
            } else {
                std::fs::create_dir_all(out)
                    .with_context(|| format!("creating {}", out.display()))?;
                atomic_write(&path, config.to_toml()?.as_bytes())
                    .with_context(|| format!("writing {}", path.display()))?;
            }
        }
        // It is of the run that began the directory.
        if out.join("run.toml").exists() {
            return Ok(());
        }
        run_info::write(out, self.finetune.seed, None)
    }

    /// Both as TOML, one behind the other.
    ///
    /// # Errors
    /// If a value cannot be written as TOML.
    pub fn to_toml(&self) -> Result<String> {
        Ok(format!("{}\n{}", self.pretrain.to_toml()?, self.finetune.to_toml()?))
    }
}
