//! Both stages of the body method, and networks that they train: their configs.

use anyhow::{Result, bail};
use evpose_cli::configs;
use evpose_cli::ranges::within;
use evpose_task::Experiment as _;
use evpose_task::body::{BodyConfig, BodySourceKind, LabelTime};

/// Arguments of commands that train both stages.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct StageArgs {
    /// The first stage: a TOML file, or an embedded config
    #[arg(long, default_value = "pretrain")]
    pub(crate) pretrain: String,
    /// The second stage: a TOML file, or an embedded config
    #[arg(long, default_value = "finetune")]
    pub(crate) finetune: String,
    /// Optimiser steps of every training, instead of the configs'
    #[arg(long, default_value_t = 1_500, value_parser = within(1..=1_000_000_000_u64))]
    pub(crate) steps: u64,
}

/// Configs of both stages of the full method.
#[derive(Debug, Clone)]
pub(crate) struct Stages {
    /// On stills.
    pub(crate) pretrain: BodyConfig,
    /// On recordings.
    pub(crate) finetune: BodyConfig,
}

impl Stages {
    /// Loads both configs.
    pub(crate) fn load(args: &StageArgs, overrides: &[String]) -> Result<Self> {
        let load = |config: &str| -> Result<BodyConfig> {
            let mut config: BodyConfig = configs::load(config, overrides)?;
            config.training.steps = args.steps;
            // Without a single validation a training would choose no best network.
            config.training.steps_per_validation =
                config.training.steps_per_validation.min(args.steps);
            // Evaluated at the rate of the training labels.
            config.evaluation.every_ms = config.data.every_ms;
            Ok(config)
        };
        let (pretrain, finetune) = (load(&args.pretrain)?, load(&args.finetune)?);
        // The second stage starts from the weights of the first, which have to fit.
        if pretrain.network != finetune.network || pretrain.image.side_px != finetune.image.side_px
        {
            bail!("both stages must have the same [network] and image.side_px");
        }
        Ok(Self { pretrain, finetune })
    }

    /// Both under a seed.
    pub(crate) fn with_seed(&self, seed: u64) -> Self {
        let of = |config: &BodyConfig| BodyConfig { seed, ..config.clone() };
        Self { pretrain: of(&self.pretrain), finetune: of(&self.finetune) }
    }

    /// Files that say what a study is of.
    pub(crate) fn inputs(&self) -> Result<Vec<(&'static str, String)>> {
        let (pretrain, finetune) = (self.pretrain.to_toml()?, self.finetune.to_toml()?);
        Ok(vec![("pretrain.toml", pretrain), ("finetune.toml", finetune)])
    }
}

const FIXED_COUNT: usize = 7_500;

/// A network of MoveEnet and how it is trained.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Network {
    /// EROS-like stills alone.
    Pretrained,
    /// Stills, then recordings as EROS.
    Full,
    /// Recordings as EROS alone.
    Scratch,
    /// Recordings as frames of a fixed number of events, labelled at their mean time.
    FixedCount,
    /// Recordings as integrated polarities.
    Pim,
    /// Grey stills alone.
    GreyPretrained,
    /// Grey stills, then grey frames at the same times as the recordings.
    Grey,
}

impl Network {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Pretrained => "pretrained",
            Self::Full => "full",
            Self::Scratch => "scratch",
            Self::FixedCount => "fixed-count",
            Self::Pim => "pim",
            Self::GreyPretrained => "grey-pretrained",
            Self::Grey => "grey",
        }
    }

    pub(crate) fn starts_from(self) -> Option<Self> {
        match self {
            Self::Full => Some(Self::Pretrained),
            Self::Grey => Some(Self::GreyPretrained),
            _ => None,
        }
    }

    pub(crate) fn config(self, stages: &Stages) -> BodyConfig {
        let mut config = match self {
            Self::Pretrained | Self::GreyPretrained => stages.pretrain.clone(),
            _ => stages.finetune.clone(),
        };
        // The directory of the study decides it: see `train`.
        config.start_from = None;
        match self {
            Self::Pretrained | Self::Full | Self::Scratch => {}
            Self::FixedCount => {
                config.image.representation = format!("fixed-count:n={FIXED_COUNT}");
                config.data.label_at = LabelTime::MeanOf(FIXED_COUNT);
            }
            Self::Pim => config.image.representation = "pim".to_owned(),
            Self::GreyPretrained => config.data.source = BodySourceKind::GreyStills,
            Self::Grey => config.data.source = BodySourceKind::GreyRecordings,
        }
        // The blur is for images of events, which single events make rough.
        if matches!(self, Self::GreyPretrained | Self::Grey) {
            config.image.blur = None;
        }
        config
    }
}
