//! The common part of studies: rows times seeds over one experiment, one table, one page, resumable, in shards.
//!
//! * [`StudyArgs`], [`SeedArgs`]: their arguments.
//! * [`StudyDirectory`]: files of a study, and which of its trials are finished.
//! * [`Study`], [`StudyPlan`]: its trials, and the loop over them.
//! * [`Training`]: a network that is trained once, whoever needs it.
//! * [`Outcome`]: means over seeds with intervals, and published findings, tested.
//! * [`StudyReport`]: tables and curves, as Markdown and as a page.

mod directory;
mod outcome;
mod report;
mod training;
mod trials;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use burn::tensor::Device;
use evpose_cli::args::{ConfigArgs, DeviceArgs};
use evpose_cli::machine::Machine;
use evpose_cli::progress::say;
use evpose_cli::tasks::PoseExperiment;
use evpose_sim::Shard;

pub(crate) use directory::{StudyDirectory, exclusively};
pub(crate) use outcome::{
    Finding, Measure, Measured, Outcome, Relation, StudyRow, Verdict, measure, metric, verdict,
};
pub(crate) use report::{StudyReport, StudyTable, mean_curve, pck_charts, strings};
pub(crate) use training::{Training, options, training_s};
pub(crate) use trials::{Study, StudyPlan, TrialIndex, Trials, Written};

/// How a verdict follows from an interval, for legends.
pub(crate) const VERDICTS: &str = "found where all of it agrees with what was published, reversed \
    where all of it contradicts, else within noise";

/// Arguments of every study.
#[derive(Debug, clap::Args)]
pub struct StudyArgs {
    /// Change one field of all trainings, for example --set training.steps=500 (may be repeated)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// Directory for data, trainings, tables and the page
    #[arg(long)]
    pub out: PathBuf,
    /// Keep what an interrupted study in the directory finished, and go on, or add to it
    #[arg(long)]
    pub resume: bool,
    /// Run only shard I of N of the trials (I from 1), which are rows times seeds; shards share OUT, and whoever
    /// ends last, or the command without --shard and with --resume, writes the whole table
    #[arg(long, value_name = "I/N", default_value_t = Shard::WHOLE, hide_default_value = true)]
    pub shard: Shard,
    /// Device and threads.
    #[command(flatten)]
    pub device: DeviceArgs,
}

impl StudyArgs {
    /// Opens the device: one that is missing is an error before anything is simulated.
    pub(crate) fn open(&self) -> Result<Device> {
        evpose_kernels::keep_freed_memory();
        self.device.open()
    }

    pub(crate) fn directory(&self) -> StudyDirectory {
        StudyDirectory::new(&self.out)
    }

    /// A config with the changes of `--set`.
    pub(crate) fn config(&self, config: &str) -> ConfigArgs {
        ConfigArgs { config: config.to_owned(), overrides: self.overrides.clone() }
    }

    /// Prints where the study runs, and where its results will be.
    pub(crate) fn say_location(&self) {
        say(format!("machine: {}", Machine::this()));
        say(format!("output:  {}", self.out.display()));
    }
}

/// How often a study is repeated.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct SeedArgs {
    /// Number of seeds, from that of the config on: intervals are over seeds
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=100))]
    pub seeds: u64,
}

impl SeedArgs {
    /// As many seeds, from the first on.
    pub(crate) fn all(self, first: u64) -> Result<Vec<u64>> {
        let seeds: Option<Vec<u64>> = (0..self.seeds).map(|i| first.checked_add(i)).collect();
        seeds.context("config field `seed`: too large to count on from")
    }
}

/// Simulates the missing sequences of a directory, by one shard while others wait.
pub(crate) fn simulate(experiment: &dyn PoseExperiment, data: &Path, label: &str) -> Result<()> {
    let simulated = exclusively(data, || experiment.simulate(data, label))?;
    say(format!("    {simulated}"));
    Ok(())
}

/// Seeds as text: `1, 2, 3`.
pub(crate) fn listed(seeds: &[u64]) -> String {
    seeds.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")
}

/// Seeds as a study is repeated over them.
pub(crate) fn seed_names(seeds: &[u64]) -> Vec<String> {
    seeds.iter().map(|seed| format!("seed {seed}")).collect()
}
