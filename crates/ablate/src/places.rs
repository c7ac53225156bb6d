//! Directories and files of an ablation, and which of its steps are finished.
//!
//! `data/seed-1/train` and `held-out`, shared by all rows; `rows/lnes-33/seed-1`, a training's own
//! directory with `trial.json` once it is evaluated. What is not finished has another name or is not
//! there, so that whatever is found can be kept.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use evpose_core::atomic_write;
use evpose_task::hand::HandConfig;
use serde::Serialize;
use serde::de::DeserializeOwned;

use evpose_app::progress::say;
use evpose_app::recorded;
use evpose_app::run_info;

/// The directory of an ablation.
pub(super) struct Places<'a> {
    out: &'a Path,
}

impl<'a> Places<'a> {
    /// Makes `out` ready for the ablation of `base`; what it holds already is kept if `resume` is
    /// set and it is of the same base.
    pub(super) fn open(out: &'a Path, base: &HandConfig, resume: bool) -> Result<Self> {
        let config = out.join("config.toml");
        if out.read_dir().is_ok_and(|mut entries| entries.next().is_some()) {
            if !resume {
                bail!("{} is not empty: add --resume, or choose another --out", out.display());
            }
            if !config.exists() {
                bail!("{} holds no ablation: choose another --out", out.display());
            }
            if HandConfig::load(&config, &[])? != *base {
                bail!(
                    "{} differs from the config given: give the same, or another --out",
                    config.display()
                );
            }
            // Who began it stays written; who made each trial stands beside the trial.
            return Ok(Self { out });
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

    /// The training of a row under a seed.
    pub(super) fn run(&self, row: &str, seed: u64) -> PathBuf {
        self.out.join("rows").join(row).join(format!("seed-{seed}"))
    }

    /// A result of the whole.
    pub(super) fn result(&self, name: &str) -> PathBuf {
        self.out.join(name)
    }

    /// Simulates the sequences of a seed, those that are not there yet.
    pub(super) fn simulate(&self, base: &HandConfig, seed: u64) -> Result<()> {
        let config = HandConfig { seed, ..base.clone() };
        let sets = [
            (self.train(seed), config.clone()),
            (self.held_out(seed), recorded::held_out(&config)),
        ];
        for (dir, config) in sets {
            if dir.exists() {
                continue;
            }
            let unfinished = dir.with_extension("partial");
            if unfinished.exists() {
                fs::remove_dir_all(&unfinished)
                    .with_context(|| format!("removing {}", unfinished.display()))?;
            }
            let recorded = recorded::record(&config, &unfinished, "simulating")?;
            fs::rename(&unfinished, &dir)
                .with_context(|| format!("renaming {}", unfinished.display()))?;
            say(format!("{}: {recorded}", dir.display()));
        }
        Ok(())
    }
}

/// Reads a JSON file of an ablation; none where it is absent.
pub(super) fn read<T: DeserializeOwned>(path: &Path) -> Result<Option<T>> {
    if !path.exists() {
        return Ok(None);
    }
    let text = fs::read(path).with_context(|| format!("reading {}", path.display()))?;
    serde_json::from_slice(&text).map(Some).with_context(|| {
        format!("{}: not written by this version; remove it to do it again", path.display())
    })
}

/// Writes a file of ours, whole or not at all.
pub(super) fn write<T: Serialize>(path: &Path, value: &T) -> Result<()> {
    let text = serde_json::to_string_pretty(value)? + "\n";
    atomic_write(path, text.as_bytes()).with_context(|| format!("writing {}", path.display()))
}
