//! The files of a search.
//!
//! | file | content |
//! |---|---|
//! | `config.toml`, `over.toml`, `tune.toml`, `run.toml` | the config, the ranges, the plan, seed and build |
//! | `data/` | recordings of all trials, without `--data` |
//! | `trials/0007/run` | training run of a trial |
//! | `trials/0007/rung-1.json` | its result at the end of a rung |
//! | `tune.json`, `trials.csv`, `tune.html`, `best.toml` | results |
//!
//! A file has its final name once it is complete, and none holds what differs among shards, so that
//! a search goes on from whatever it finds.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use evpose_cli::json::{read_result, write_result};
use evpose_cli::run_info::{CONFIG, claim_origin};
use evpose_sim::Shard;

use crate::study;
use crate::tune::rung_result::RungResult;

/// Names in the directory while a search begins.
const FILES: [&str; 5] = ["tune.toml", "over.toml", CONFIG, "run.toml", "data"];

/// The directory of a search.
pub(crate) struct SearchDirectory<'a> {
    out: &'a Path,
}

impl<'a> SearchDirectory<'a> {
    /// Opens `out` for the search of a config, a space and a plan, each the text of a file. What
    /// is finished is kept if `resume` is set and the three are the same.
    ///
    /// # Errors
    /// If the directory is of another search, or holds trials of this shard and `resume` is not
    /// set.
    pub(crate) fn open(
        out: &'a Path,
        seed: u64,
        [config, over, plan]: [&str; 3],
        shard: Shard,
        trials: u64,
        resume: bool,
    ) -> Result<Self> {
        let directory = Self { out };
        let has_own = || shard.sequences_of(trials).any(|trial| directory.trial(trial).exists());
        if shard.is_whole() || has_own() {
            study::is_begun(out, resume)?;
        }
        if !out.join(CONFIG).exists() && study::holds_others(out, &FILES) {
            bail!("{} holds no search: choose another --out", out.display());
        }
        // The config last, so that its existence implies that of the others.
        for (name, text) in [("tune.toml", plan), ("over.toml", over), (CONFIG, config)] {
            study::claim(&out.join(name), text)?;
        }
        claim_origin(out, seed)?;
        Ok(directory)
    }

    /// Recordings of all trials.
    pub(crate) fn data(&self) -> PathBuf {
        self.out.join("data")
    }

    fn trial(&self, trial: u64) -> PathBuf {
        self.out.join(format!("trials/{trial:04}"))
    }

    /// The training run of a trial.
    pub(crate) fn run(&self, trial: u64) -> PathBuf {
        self.trial(trial).join("run")
    }

    fn result_path(&self, trial: u64, rung: usize) -> PathBuf {
        self.trial(trial).join(format!("rung-{}.json", rung + 1))
    }

    /// The result of a trial at the end of a rung; none while there is none.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(crate) fn result(&self, trial: u64, rung: usize) -> Result<Option<RungResult>> {
        read_result(&self.result_path(trial, rung))
    }

    /// Writes the result of a trial at the end of a rung.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(crate) fn write_result(&self, trial: u64, rung: usize, result: &RungResult) -> Result<()> {
        write_result(&self.result_path(trial, rung), result)
    }

    /// Removes the checkpoints of a trial that nobody will continue: those of its optimiser are
    /// several times as large as its network.
    ///
    /// # Errors
    /// If they cannot be removed.
    pub(crate) fn remove_checkpoints(&self, trial: u64) -> Result<()> {
        let path = self.run(trial).join("checkpoint");
        match std::fs::remove_dir_all(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(error).with_context(|| format!("removing {}", path.display()))
            }
            _ => Ok(()),
        }
    }

    /// Path of a file of the directory.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.out.join(name)
    }

    /// Writes a file of the directory.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(crate) fn write(&self, name: &str, text: &str) -> Result<()> {
        study::write(&self.path(name), text)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::tune::rung_result::TrialStatus;
    use crate::tune::rung_result::tests::result;

    #[test]
    fn a_directory_is_of_one_search_and_shards_share_it() {
        let parent = tempfile::tempdir().unwrap();
        let out = parent.path().join("search");
        let open = |plan: &str, shard: &str, resume| {
            let texts = ["seed = 1\n", "a = { uniform = [0, 1] }\n", plan];
            let shard = shard.parse().unwrap();
            let opened = SearchDirectory::open(&out, 1, texts, shard, 4, resume);
            opened.map_err(|error| error.to_string())
        };
        let directory = open("trials = 4\n", "1/2", false).unwrap();
        assert_eq!(directory.result(2, 0).unwrap(), None);
        let done = result(TrialStatus::Trained, &[0.5]);
        std::fs::create_dir_all(directory.run(2)).unwrap();
        directory.write_result(2, 0, &done).unwrap();
        assert_eq!(directory.result(2, 0).unwrap(), Some(done));
        // Trial 2 is of the first shard.
        assert!(open("trials = 4\n", "2/2", false).is_ok());
        for shard in ["1/2", "1/1"] {
            let message = open("trials = 4\n", shard, false).err().unwrap();
            assert!(message.contains("--resume"), "{message}");
            assert!(open("trials = 4\n", shard, true).is_ok());
        }
        let message = open("trials = 5\n", "2/2", true).err().unwrap();
        assert!(message.contains("tune.toml differs"), "{message}");
        // Of another process that has just begun.
        std::fs::remove_file(out.join(CONFIG)).unwrap();
        std::fs::remove_dir_all(out.join("trials")).unwrap();
        std::fs::write(out.join("config.toml.77-0.tmp"), "").unwrap();
        assert!(open("trials = 4\n", "2/2", false).is_ok());
        let foreign = SearchDirectory::open(parent.path(), 1, ["", "", ""], Shard::WHOLE, 4, true);
        assert!(foreign.err().unwrap().to_string().contains("no search"));
    }
}
