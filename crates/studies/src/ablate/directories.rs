//! Directories and files of a study, and which of its steps are finished.
//!
//! `data/seed-1/train` and `held-out` are shared by all rows; `rows/lnes-33/seed-1` is the
//! directory of a training, with `trial.json` once it is evaluated. Unfinished files have another
//! name or do not exist, so that every existing file is complete.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use evpose_task::Experiment as _;
use evpose_task::hand::HandConfig;

use evpose_cli::progress::say;
use evpose_cli::recorded;
use evpose_cli::run_info;

use crate::study;

/// Directory of a study.
pub(super) struct StudyDirectory<'a> {
    out: &'a Path,
}

impl<'a> StudyDirectory<'a> {
    /// Opens `out` for the study of `base`. Existing files are kept if `resume` is set and the
    /// config is the same.
    pub(super) fn open(out: &'a Path, base: &HandConfig, resume: bool) -> Result<Self> {
        let config = out.join("config.toml");
        if study::is_begun(out, resume)? && config.exists() {
            if HandConfig::read(&config)? != *base {
                bail!(
                    "{} differs from the config given: give the same, or another --out",
                    config.display()
                );
            }
            // `run.toml` of the first process stays; each trial has its own provenance.
            return Ok(Self { out });
        }
        // As a process leaves it that was killed as it began.
        if study::holds_others(out, &["run.toml", "config.toml"]) {
            bail!("{} holds no ablation: choose another --out", out.display());
        }
        run_info::write(out, base.seed, Some(base))?;
        Ok(Self { out })
    }

    /// Sequences to train on.
    pub(super) fn train(&self, seed: u64) -> PathBuf {
        self.data(seed).join("train")
    }

    /// Sequences of the test set.
    pub(super) fn held_out(&self, seed: u64) -> PathBuf {
        self.data(seed).join("held-out")
    }

    fn data(&self, seed: u64) -> PathBuf {
        self.out.join(format!("data/seed-{seed}"))
    }

    /// Directory of the training of a row under a seed.
    pub(super) fn run(&self, row: &str, seed: u64) -> PathBuf {
        self.out.join("rows").join(row).join(format!("seed-{seed}"))
    }

    /// Simulates the missing sequences of a seed.
    pub(super) fn simulate(&self, base: &HandConfig, seed: u64) -> Result<()> {
        let config = HandConfig { seed, ..base.clone() };
        let sets = [(self.train(seed), config.clone()), (self.held_out(seed), config.held_out())];
        for (dir, config) in sets {
            if dir.exists() {
                continue;
            }
            let unfinished = dir.with_extension("partial");
            if unfinished.exists() {
                fs::remove_dir_all(&unfinished)
                    .with_context(|| format!("removing {}", unfinished.display()))?;
            }
            // Under another name first: a directory of the final name is complete.
            let recorded = recorded::record(&config, &unfinished, "simulating")?;
            fs::rename(&unfinished, &dir)
                .with_context(|| format!("renaming {}", unfinished.display()))?;
            say(format!("{}: {recorded}", dir.display()));
        }
        Ok(())
    }
}
