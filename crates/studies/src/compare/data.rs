//! Recordings or images to train on and to evaluate on.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use evpose_cli::recorded;
use evpose_task::body::{BodyConfig, BodySourceKind};
use evpose_train::body::{BodyFrames, BodyRecordings, holds_annotations};
use serde::Serialize;

use crate::compare::networks;
use crate::compare::spatial::Scenes;
use crate::compare::stages::Stages;
use crate::compare::system::{Images, System, Test, Weights};
use crate::study::StudyDirectory;

/// Directories to train on and to evaluate on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(crate) enum Data {
    /// People of the config, simulated for each seed.
    Simulated,
    /// Directories of the user.
    Given {
        train: PathBuf,
        /// To evaluate on.
        test: PathBuf,
        /// Whether they hold images with annotations, not recordings.
        has_images: bool,
    },
}

impl Data {
    /// Those of the user, or simulated ones.
    pub(crate) fn new(train: Option<&PathBuf>, test: Option<&PathBuf>) -> Result<Self> {
        let (Some(train), Some(test)) = (train, test) else { return Ok(Self::Simulated) };
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
            // The mean pose is that of recordings, which a set of images lacks.
            Images::Eros if system.weights != Weights::MeanPose => None,
            _ if *has_images => Some(format!("{test} holds EROS images, not recordings")),
            _ => None,
        }
    }

    /// Directory to train on, simulated where it is missing.
    pub(crate) fn train(&self, study: &StudyDirectory, stages: &Stages) -> Result<PathBuf> {
        match self {
            Self::Given { train, .. } => Ok(train.clone()),
            Self::Simulated => {
                let data = study.data(stages.finetune.seed, networks::TRAIN);
                networks::simulate(&stages.finetune, &data)?;
                Ok(data)
            }
        }
    }

    /// Directory to train on, if it is the user's.
    pub(crate) fn given_train(&self) -> Option<&Path> {
        match self {
            Self::Simulated => None,
            Self::Given { train, .. } => Some(train),
        }
    }

    pub(crate) fn words(&self) -> String {
        match self {
            Self::Simulated => "simulated people that are in no training set".to_owned(),
            Self::Given { test, .. } => test.display().to_string(),
        }
    }

    /// Directory to evaluate on, simulated where it is missing.
    fn test(&self, study: &StudyDirectory, stages: &Stages, set: Test) -> Result<PathBuf> {
        match self {
            Self::Given { test, .. } => Ok(test.clone()),
            Self::Simulated => {
                let data = study.data(stages.finetune.seed, set.name());
                networks::simulate(&set.config(stages), &data)?;
                Ok(data)
            }
        }
    }

    /// Scenes of the recordings to evaluate on that several calibrated cameras show.
    pub(crate) fn scenes(
        &self,
        study: &StudyDirectory,
        stages: &Stages,
        set: Test,
    ) -> Result<Scenes> {
        match self {
            Self::Given { has_images: true, .. } => Ok(Scenes::default()),
            _ => Scenes::new(&BodyRecordings::open(&self.test(study, stages, set)?)?),
        }
    }

    /// The images of an experiment to evaluate on.
    pub(crate) fn test_frames(
        &self,
        study: &StudyDirectory,
        stages: &Stages,
        set: Test,
        mut experiment: BodyConfig,
    ) -> Result<BodyFrames> {
        let data = self.test(study, stages, set)?;
        let held_out = set.config(stages);
        // The noise before a recording is drawn by the seed: not by that of the training.
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
