//! Recordings or images to train on and to evaluate on.

use std::path::{Path, PathBuf};

use crate::ablate::{Stages, networks};
use anyhow::{Context, Result, bail};
use evpose_cli::json::{read_result, write_result};
use evpose_cli::recorded;
use evpose_task::body::{BodyConfig, BodySourceKind};
use evpose_train::body::{BodyFrames, BodyRecordings, holds_annotations};
use serde::{Deserialize, Serialize};

use crate::compare::args::CompareBodyArgs;
use crate::compare::spatial::Scenes;
use crate::compare::system::{Images, System, Weights};

/// Directories to train on and to evaluate on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Data {
    /// People of the config, simulated for each seed.
    Simulated,
    /// Directories of the user.
    Given {
        /// To train on.
        train: PathBuf,
        /// To evaluate on.
        test: PathBuf,
        /// Whether they hold images with annotations, not recordings.
        has_images: bool,
    },
}

impl Data {
    /// Those that the arguments name.
    pub(crate) fn new(args: &CompareBodyArgs) -> Result<Self> {
        let (Some(train), Some(test)) = (&args.train, &args.data) else {
            return Ok(Self::Simulated);
        };
        let [of_train, of_test] = [train, test].map(|path| holds_annotations(path));
        if of_train != of_test {
            bail!(
                "{} and {}: one holds recordings, the other images with annotations; give two of the same kind",
                train.display(),
                test.display()
            );
        }
        Ok(Self::Given { train: train.clone(), test: test.clone(), has_images: of_test })
    }

    /// Claims the directory of a comparison: results on other data are not mixed with these.
    pub(crate) fn claim(&self, out: &Path) -> Result<()> {
        let path = out.join("data.json");
        match read_result::<Self>(&path)? {
            Some(there) if there != *self => bail!(
                "{}: the comparison there is of other data; give the same --data and --train, or another --out",
                path.display()
            ),
            Some(_) => Ok(()),
            None => write_result(&path, self),
        }
    }

    /// The stages, trained on these data.
    pub(crate) fn stages(&self, mut stages: Stages) -> Stages {
        if let Self::Given { has_images: true, .. } = self {
            stages.finetune.data.source = BodySourceKind::Annotations;
        }
        stages
    }

    /// Why a system cannot be run on these data.
    pub(crate) fn missing_input(&self, system: &System) -> Option<String> {
        let Self::Given { has_images, test, .. } = self else { return None };
        let test = test.display();
        match system.images {
            Images::Grey if !test_is_simulated(self) => Some(format!(
                "{test} has no grey frames: they are rendered for directories of `evpose simulate`"
            )),
            Images::Eros if system.weights != Weights::MeanPose => None,
            _ if *has_images => Some(format!("{test} holds EROS images, not recordings")),
            _ => None,
        }
    }

    /// Directory to train on.
    pub(crate) fn train(&self, out: &Path, seed: u64) -> PathBuf {
        match self {
            Self::Simulated => networks::train_data(out, seed),
            Self::Given { train, .. } => train.clone(),
        }
    }

    /// Directory to train on, if it is the user's.
    pub(crate) fn given_train(&self) -> Option<&Path> {
        match self {
            Self::Simulated => None,
            Self::Given { train, .. } => Some(train),
        }
    }

    /// Directory to evaluate on, simulated where it is missing.
    pub(crate) fn test(&self, out: &Path, stages: &Stages) -> Result<PathBuf> {
        match self {
            Self::Given { test, .. } => Ok(test.clone()),
            Self::Simulated => {
                let seed = stages.finetune.seed;
                let data = out.join("data").join(format!("seed-{seed}")).join("held-out");
                recorded::prepare(&stages.finetune.held_out(), &data)?;
                Ok(data)
            }
        }
    }

    /// Scenes of the recordings to evaluate on that several calibrated cameras show.
    pub(crate) fn scenes(&self, out: &Path, stages: &Stages) -> Result<Scenes> {
        match self {
            Self::Given { has_images: true, .. } => Ok(Scenes::default()),
            _ => Scenes::new(&BodyRecordings::open(&self.test(out, stages)?)?),
        }
    }

    /// The images of an experiment to evaluate on.
    pub(crate) fn test_frames(
        &self,
        out: &Path,
        stages: &Stages,
        mut experiment: BodyConfig,
    ) -> Result<BodyFrames> {
        let data = self.test(out, stages)?;
        let held_out = stages.finetune.held_out();
        (experiment.seed, experiment.simulation) = (held_out.seed, held_out.simulation);
        recorded::frames(&experiment, &data).with_context(|| format!("reading {}", data.display()))
    }
}

/// Whether photographs of the test recordings can be rendered.
fn test_is_simulated(data: &Data) -> bool {
    match data {
        Data::Simulated => true,
        Data::Given { test, .. } => test.join("config.toml").is_file(),
    }
}
