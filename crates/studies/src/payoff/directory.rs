//! Directory of a study: its inputs, data, networks and results.
//!
//! | file | content |
//! |---|---|
//! | `config.toml`, `run.toml` | resolved config; command, seed, commit |
//! | `models/given.toml`, `models/corrected.toml`, `models/camera.toml` | sensor models |
//! | `held-out/` | recordings of the camera, with `--camera` |
//! | `seed-1/given/data`, `seed-1/given/network` | training data and network of a model under a seed |
//! | `payoff.json`, `report.html` | results |
//!
//! A file has its final name once it is complete, so that a study resumes from whatever it finds.

use std::path::{Path, PathBuf};

use anyhow::Result;
use evpose_cli::run_info;

use crate::study;

/// Directory of a study.
pub(crate) struct StudyDirectory<'a> {
    out: &'a Path,
}

impl<'a> StudyDirectory<'a> {
    /// Opens `out` for a study of these input files (name and content). Existing files are kept if
    /// `resume` is set and the inputs are the same.
    pub(crate) fn open(
        out: &'a Path,
        seed: u64,
        inputs: &[(String, String)],
        resume: bool,
    ) -> Result<Self> {
        study::is_begun(out, resume)?;
        for (name, text) in inputs {
            study::claim(&out.join(name), text)?;
        }
        run_info::write(out, seed, None)?;
        Ok(Self { out })
    }

    /// Recordings of the camera.
    pub(crate) fn held_out(&self) -> PathBuf {
        self.out.join("held-out")
    }

    /// Training data of a model under a seed.
    pub(crate) fn data(&self, seed: u64, model: &str) -> PathBuf {
        self.out.join(format!("seed-{seed}/{model}/data"))
    }

    /// Training run of a model under a seed.
    pub(crate) fn network(&self, seed: u64, model: &str) -> PathBuf {
        self.out.join(format!("seed-{seed}/{model}/network"))
    }

    /// Path of a result.
    pub(crate) fn result(&self, name: &str) -> PathBuf {
        self.out.join(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_study_resumes_with_the_same_inputs_only() -> Result<()> {
        let dir = tempfile::tempdir()?;
        let inputs = |text: &str| [("models/given.toml".to_owned(), text.to_owned())];
        let open = |text: &str, resume| {
            let opened = StudyDirectory::open(dir.path(), 1, &inputs(text), resume);
            opened.map_or_else(|error| error.to_string(), |_| String::new())
        };
        assert_eq!(open("a", false), "");
        assert!(open("a", false).contains("--resume"));
        assert_eq!(open("a", true), "");
        assert!(open("b", true).contains("given.toml differs"));
        assert_eq!(std::fs::read_to_string(dir.path().join("models/given.toml"))?, "a");
        Ok(())
    }
}
