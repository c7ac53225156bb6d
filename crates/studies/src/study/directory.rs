//! The directory of a study: what it is of, and the results of its trials.
//!
//! A file has its final name once it is complete, and none holds what differs among shards, so that a study goes on
//! from whatever it finds. The result of a trial is the last of its files, and marks it as finished.

use std::fs::{File, create_dir_all};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use evpose_cli::json::read_result;
use evpose_cli::outputs::write_file;
use evpose_cli::run_info::claim_origin;
use evpose_core::temporary_target;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::StudyArgs;

/// Seed and build of a study.
const ORIGIN: &str = "run.toml";
/// Recordings of a study.
const DATA: &str = "data";

#[derive(Debug, Clone)]
pub(crate) struct StudyDirectory(PathBuf);

impl StudyDirectory {
    pub(crate) fn new(out: &Path) -> Self {
        Self(out.to_owned())
    }

    /// Claims it for a study of `inputs`, each the name and the text of a file. What is finished is kept if `--resume`
    /// is given and the inputs are the same. `trials` are paths of the results of all trials.
    pub(crate) fn claim(
        &self,
        args: &StudyArgs,
        seed: u64,
        inputs: &[(&str, String)],
        trials: impl IntoIterator<Item = String>,
    ) -> Result<()> {
        let out = self.0.display();
        // Shards share a directory.
        let is_begun = match args.shard.is_whole() {
            true => self.0.read_dir().is_ok_and(|mut entries| entries.next().is_some()),
            false => (0..)
                .zip(trials)
                .any(|(index, trial)| args.shard.owns(index) && self.path(&trial).exists()),
        };
        if is_begun && !args.resume {
            bail!("{out} is not empty: add --resume, or choose another --out");
        }
        // In this order: the last input is written before anything else.
        let holds_others = self.holds_others(inputs);
        let is_claimed = inputs.last().is_some_and(|(name, _)| self.path(name).exists());
        if holds_others && !is_claimed {
            bail!("{out} holds no such study: choose another --out");
        }
        for (name, text) in inputs {
            self.claim_input(name, text)?;
        }
        // Of the program that began: trials that depend on the build have their own.
        if !self.path(ORIGIN).exists() {
            claim_origin(&self.0, seed)?;
        }
        Ok(())
    }

    /// Whether there is anything that no study leaves which was killed as it began, or that begins at this moment in
    /// another process.
    fn holds_others(&self, inputs: &[(&str, String)]) -> bool {
        let first = |name: &'_ str| name.split('/').next().unwrap_or_default().to_owned();
        let mut known: Vec<String> = inputs.iter().map(|(name, _)| first(name)).collect();
        known.extend([ORIGIN.to_owned(), DATA.to_owned()]);
        let entries = self.0.read_dir().into_iter().flatten().flatten();
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).any(|name| {
            let name = temporary_target(&name).unwrap_or(&name);
            !known.iter().any(|known| known == name)
        })
    }

    /// Writes an input where it is absent. Another process may do the same at once.
    fn claim_input(&self, name: &str, text: &str) -> Result<()> {
        let path = self.path(name);
        if !path.exists() {
            self.write(name, text)?;
        }
        // Read back even if it was just written: another process may have been the last.
        let there = std::fs::read_to_string(&path)
            .with_context(|| format!("reading {}", path.display()))?;
        if there != text {
            let pairs = there.lines().zip(text.lines()).find(|(there, given)| there != given);
            let (there, given) = pairs.unwrap_or_default();
            bail!(
                "{} differs from what is given, `{there}` there and `{given}` here: give the same, or another --out",
                path.display()
            );
        }
        Ok(())
    }

    pub(crate) fn root(&self) -> &Path {
        &self.0
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Recordings under a seed: `train`, or those of a test set.
    pub(crate) fn data(&self, seed: u64, set: &str) -> PathBuf {
        self.path(&format!("{DATA}/seed-{seed}/{set}"))
    }

    /// The result of a trial; none while it is not finished.
    pub(crate) fn result<T: DeserializeOwned>(&self, trial: &str) -> Result<Option<T>> {
        read_result(&self.path(trial))
    }

    /// Writes the result of a trial, which marks it as finished.
    pub(crate) fn write_result(&self, trial: &str, result: &impl Serialize) -> Result<()> {
        self.write(trial, &(serde_json::to_string_pretty(result)? + "\n"))
    }

    /// Writes a file of it, atomically.
    pub(crate) fn write(&self, name: &str, text: &str) -> Result<()> {
        let path = self.path(name);
        if let Some(parent) = path.parent() {
            create_dir_all(parent).with_context(|| format!("creating {}", parent.display()))?;
        }
        write_file(&path, text)
    }
}

/// Makes what is at `path`, one process at a time: `make` sees what others have made.
pub(crate) fn exclusively<T>(path: &Path, make: impl FnOnce() -> Result<T>) -> Result<T> {
    let mut name = path.as_os_str().to_owned();
    name.push(".lock");
    if let Some(parent) = path.parent() {
        create_dir_all(parent).with_context(|| format!("creating {}", parent.display()))?;
    }
    let file = File::options().create(true).append(true).open(&name);
    let file = file.with_context(|| format!("locking {}", path.display()))?;
    // On file systems without locks, some of them of the network, nobody is kept out.
    let _ = file.lock();
    let made = make();
    // Ended here, and by the operating system if the process is killed. The file stays: removed, it could be
    // locked twice.
    drop(file);
    made
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use evpose_cli::args::DeviceArgs;
    use evpose_nn::DeviceKind;

    use super::*;

    pub(crate) fn args(out: &Path, shard: &str, resume: bool) -> StudyArgs {
        let device = DeviceArgs { device: DeviceKind::Flex, threads: None };
        let (out, shard) = (out.to_owned(), shard.parse().unwrap());
        StudyArgs { overrides: Vec::new(), out, resume, shard, device }
    }

    #[test]
    fn a_directory_is_of_one_study_and_shards_share_it() {
        let parent = tempfile::tempdir().unwrap();
        let out = parent.path().join("study");
        let directory = StudyDirectory::new(&out);
        let open = |text: &str, shard: &str, resume| {
            let inputs =
                [("models/a.toml", "a = 1\n".to_owned()), ("config.toml", text.to_owned())];
            let trials = (0..4).map(|trial| format!("trials/{trial}.json"));
            let claimed = directory.claim(&args(&out, shard, resume), 1, &inputs, trials);
            claimed.map_err(|error| error.to_string())
        };
        open("seed = 1\n", "1/2", false).unwrap();
        assert!(out.join("models/a.toml").exists() && out.join(ORIGIN).exists());
        assert_eq!(directory.result::<u64>("trials/2.json").unwrap(), None);
        directory.write_result("trials/2.json", &7).unwrap();
        assert_eq!(directory.result::<u64>("trials/2.json").unwrap(), Some(7));
        // Trial 2 is of the first shard.
        assert!(open("seed = 1\n", "2/2", false).is_ok());
        for shard in ["1/2", "1/1"] {
            let message = open("seed = 1\n", shard, false).unwrap_err();
            assert!(message.contains("--resume"), "{message}");
            assert!(open("seed = 1\n", shard, true).is_ok());
        }
        let message = open("seed = 2\n", "2/2", true).unwrap_err();
        assert!(message.contains("config.toml differs") && message.contains("`seed = 1`"));
        // Of another process that has just begun.
        std::fs::remove_file(out.join("config.toml")).unwrap();
        std::fs::remove_dir_all(out.join("trials")).unwrap();
        std::fs::write(out.join("config.toml.77-0.tmp"), "").unwrap();
        assert!(open("seed = 1\n", "2/2", false).is_ok());
        let foreign = args(parent.path(), "1/1", true);
        let inputs = [("config.toml", String::new())];
        let refused = StudyDirectory::new(parent.path()).claim(&foreign, 1, &inputs, []);
        assert!(refused.unwrap_err().to_string().contains("no such study"));
    }

    #[test]
    fn what_several_need_is_made_once() {
        let parent = tempfile::tempdir().unwrap();
        let path = parent.path().join("data/seed-1");
        let make = || {
            exclusively(&path, || {
                let is_missing = !path.exists();
                create_dir_all(&path)?;
                Ok(usize::from(is_missing))
            })
        };
        let made = std::thread::scope(|scope| {
            let workers: Vec<_> = (0..4).map(|_| scope.spawn(make)).collect();
            workers.into_iter().map(|worker| worker.join().unwrap().unwrap()).sum::<usize>()
        });
        assert_eq!(made, 1);
    }
}
