//! Arguments of `evpose compare`, and of studies of networks of bodies.

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValue, PossibleValuesParser};
use evpose_core::Registry;

use crate::compare::stages::StageArgs;
use crate::compare::system::{FileKind, SYSTEMS, System, Weights};
use crate::study::{SeedArgs, StudyArgs};

/// Arguments of studies of networks of bodies.
#[derive(Debug, clap::Args)]
pub(crate) struct BodyStudyArgs {
    #[command(flatten)]
    pub(crate) stages: StageArgs,
    #[command(flatten)]
    pub(crate) seeds: SeedArgs,
    /// Concurrent trainings, each with its share of the threads [default: one per thread, at most
    /// 4; 1 on other devices than the CPU]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) jobs: Option<u16>,
    #[command(flatten)]
    pub(crate) study: StudyArgs,
}

#[derive(Debug, Default, clap::Args)]
pub(crate) struct NetworkFiles {
    /// A network of OpenPose (COCO, BODY_25) or of lightweight OpenPose
    #[arg(long, value_name = "FILE.onnx")]
    openpose: Option<PathBuf>,
    /// A single-pose model of MoveNet, Lightning or Thunder
    #[arg(long, value_name = "FILE.onnx")]
    movenet: Option<PathBuf>,
}

impl NetworkFiles {
    /// The file of a system's weights.
    pub(crate) fn of(&self, system: &System) -> Option<&Path> {
        match system.weights {
            Weights::File(FileKind::OpenPose) => self.openpose.as_deref(),
            Weights::File(FileKind::MoveNet) => self.movenet.as_deref(),
            _ => None,
        }
    }
}

/// The comparisons of systems.
#[derive(Debug, clap::Subcommand)]
#[command(after_help = "Start with:\n  evpose compare body --out runs/compare")]
pub enum CompareCommand {
    /// Systems that estimate poses of people: those of MoveEnet's tables
    Body(CompareBodyArgs),
    /// Pre-training and fine-tuning of a network of bodies on clips of real images, each left out once
    Clips(super::clips::CompareClipsArgs),
}

/// Arguments of `evpose compare body`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose compare body --out runs/compare\n  \
    evpose compare body --finetune studio --out runs/studio\n  \
    evpose compare body --systems move-enet,move-enet-fixed-count --steps 800 --out runs/two\n  \
    evpose compare body --openpose body_25.onnx --movenet lightning.onnx --out runs/compare --resume\n  \
    evpose compare body --data data/test --train data/train --out runs/own\n\n\
    People are simulated once for each seed and shared by all systems. OpenPose and MoveNet are run from ONNX \
    files of yours, by a program built with the Cargo feature `onnx`; without a file their rows say how to get \
    one. docs/guide/compare.md describes the systems and the protocol.")]
pub struct CompareBodyArgs {
    /// Systems to compare, comma-separated [default: all]
    #[arg(long, value_delimiter = ',', value_parser = names(&SYSTEMS))]
    pub(crate) systems: Vec<String>,
    /// Recordings with tables of poses, or images with annotations, to evaluate on [default: simulated
    /// people]
    #[arg(long, value_name = "DIR", requires = "train")]
    pub(crate) data: Option<PathBuf>,
    /// The same to train on
    #[arg(long, value_name = "DIR", requires = "data")]
    pub(crate) train: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) files: NetworkFiles,
    #[command(flatten)]
    pub(crate) body: BodyStudyArgs,
}

pub(crate) fn names(systems: &Registry<System>) -> PossibleValuesParser {
    systems.iter().map(|system| PossibleValue::new(system.name).help(system.about)).into()
}
