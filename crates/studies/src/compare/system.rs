//! The registry of systems: input, origin of the weights, published figures.
//!
//! # Source
//! Goyal et al.: *MoveEnet: Online High-Frequency Human Pose Estimation with an Event Camera*, CVPRW
//! 2023, Tables 1 and 2 (Figures 5 and 6 are their curves), section 6 for speeds.

use evpose_core::{Registry, SensorSize, registry_entry};
use evpose_task::body::BodyConfig;
use serde::Serialize;

use crate::compare::stages::{Network, Stages};

/// A system that estimates poses of people.
#[derive(Debug)]
pub(crate) struct System {
    pub(crate) name: &'static str,
    /// Description in one line.
    pub(crate) about: &'static str,
    pub(crate) images: Images,
    pub(crate) weights: Weights,
    pub(crate) test: Test,
    pub(crate) published: &'static [Figure],
}

registry_entry!(System, "system");

/// Source of a published figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(crate) enum DataSet {
    /// Front cameras of DHP19: Table 1.
    #[serde(rename = "DHP19")]
    Dhp19,
    /// Human3.6M as events: Table 2.
    #[serde(rename = "eH3.6M")]
    Eh36m,
    /// Online, with a GeForce RTX 2070.
    #[serde(rename = "online")]
    Online,
}

impl DataSet {
    /// In words.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Dhp19 => "DHP19",
            Self::Eh36m => "eH3.6M",
            Self::Online => "an RTX 2070",
        }
    }
}

/// Test set: held-out people.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Test {
    /// Those of the second stage.
    HeldOut,
    /// From a camera of 640x480 pixels.
    Vga,
    /// From hand-held cameras.
    Moving,
}

impl Test {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::HeldOut => "held-out",
            Self::Vga => "held-out-vga",
            Self::Moving => "held-out-moving",
        }
    }

    /// The recordings it is made of.
    pub(crate) fn config(self, stages: &Stages) -> BodyConfig {
        let mut config = stages.finetune.held_out();
        match self {
            Self::HeldOut => {}
            Self::Vga => config.simulation.sensor_size = SensorSize { width: 640, height: 480 },
            Self::Moving => config.simulation.moving_cameras = 1.0,
        }
        config
    }
}

#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Figure {
    pub(crate) measure: &'static str,
    pub(crate) data_set: DataSet,
    pub(crate) value: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Images {
    Eros,
    /// Frames of 7500 events, labelled at their mean time.
    FixedCount,
    /// Integrated polarities.
    Pim,
    /// Photographs at the same times.
    Grey,
}

/// Origin of a system's weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Weights {
    MoveEnet(Network),
    /// A network of others, trained here.
    Baseline(BaselineKind),
    /// An ONNX file of the user.
    File(FileKind),
    /// The mean of all training poses.
    MeanPose,
}

/// Networks of others that are trained here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BaselineKind {
    Dhp19Cnn,
    LiftMono,
}

/// Kinds of networks that are run from files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FileKind {
    OpenPose,
    MoveNet,
}

const fn dhp19(measure: &'static str, value: f64) -> Figure {
    Figure { measure, data_set: DataSet::Dhp19, value }
}

/// A figure of Human3.6M as events.
pub(crate) const fn eh36m(measure: &'static str, value: f64) -> Figure {
    Figure { measure, data_set: DataSet::Eh36m, value }
}

const fn online(value: f64) -> Figure {
    Figure { measure: "poses_per_s", data_set: DataSet::Online, value }
}

pub(crate) const MOVE_ENET: &str = "move-enet";

/// A system of the registry, of its images, weights and test set.
pub(crate) const fn system(
    name: &'static str,
    about: &'static str,
    (images, weights, test): (Images, Weights, Test),
    published: &'static [Figure],
) -> System {
    System { name, about, images, weights, test, published }
}

/// The same pose on every image.
pub(crate) const MEAN_POSE: System = system(
    "mean-pose",
    "the mean of all training poses, the same on every image: a lower bound",
    (Images::Eros, Weights::MeanPose, Test::HeldOut),
    &[],
);

#[allow(clippy::approx_constant, reason = "6.28 is a published error in pixels")]
pub(crate) static SYSTEMS: Registry<System> = Registry::new(&[
    &system(
        MOVE_ENET,
        "EROS, pre-trained on stills that look like one, fine-tuned on recordings",
        (Images::Eros, Weights::MoveEnet(Network::Full), Test::HeldOut),
        &[
            dhp19("pck_40", 0.97),
            dhp19("pck_60", 0.98),
            dhp19("mpjpe_px", 6.28),
            eh36m("pck_40", 0.89),
            eh36m("pck_80", 0.93),
            online(100.0),
        ],
    ),
    &system(
        "move-enet-fixed-count",
        "the same network on frames of 7500 events, from scratch",
        (Images::FixedCount, Weights::MoveEnet(Network::FixedCount), Test::HeldOut),
        &[eh36m("pck_40", 0.87), eh36m("pck_80", 0.93)],
    ),
    &system(
        "move-enet-wo-finetune",
        "the same network on EROS, pre-trained only",
        (Images::Eros, Weights::MoveEnet(Network::Pretrained), Test::HeldOut),
        &[eh36m("pck_40", 0.30), eh36m("pck_80", 0.52)],
    ),
    &system(
        "move-enet-wo-pretrain",
        "the same network on EROS, recordings only, from scratch",
        (Images::Eros, Weights::MoveEnet(Network::Scratch), Test::HeldOut),
        &[eh36m("pck_40", 0.59), eh36m("pck_80", 0.81)],
    ),
    &system(
        "dhp19-cnn",
        "the network of DHP19 on frames of 7500 events: a heatmap for each joint",
        (Images::FixedCount, Weights::Baseline(BaselineKind::Dhp19Cnn), Test::HeldOut),
        &[dhp19("mpjpe_px", 7.03)],
    ),
    &system(
        "lift-mono",
        "LiftMono-HPE on frames of 7500 events: heatmaps on three planes, joints in space",
        (Images::FixedCount, Weights::Baseline(BaselineKind::LiftMono), Test::HeldOut),
        &[dhp19("pck_40", 0.28), dhp19("pck_60", 0.51), dhp19("mpjpe_px", 26.79), online(2.0)],
    ),
    &system(
        "openpose-grey",
        "OpenPose on grey frames, from an ONNX file",
        (Images::Grey, Weights::File(FileKind::OpenPose), Test::HeldOut),
        &[eh36m("pck_40", 0.91), eh36m("pck_80", 0.92), online(10.0)],
    ),
    &system(
        "openpose-pim",
        "OpenPose on integrated polarities, from an ONNX file",
        (Images::Pim, Weights::File(FileKind::OpenPose), Test::HeldOut),
        &[eh36m("pck_40", 0.46), eh36m("pck_80", 0.54)],
    ),
    &system(
        "movenet-grey",
        "Google's MoveNet on grey frames, from an ONNX file",
        (Images::Grey, Weights::File(FileKind::MoveNet), Test::HeldOut),
        &[eh36m("pck_40", 0.84), eh36m("pck_80", 0.91)],
    ),
    &MEAN_POSE,
]);

/// The systems of a registry of these names, in its order, or all.
pub(crate) fn selected(registry: &Registry<System>, names: &[String]) -> Vec<&'static System> {
    let is_chosen =
        |system: &&System| names.is_empty() || names.iter().any(|name| name == system.name);
    registry.iter().copied().filter(is_chosen).collect()
}

impl System {
    /// The network of MoveEnet, where it is one.
    pub(crate) fn network(&self) -> Option<Network> {
        match self.weights {
            Weights::MoveEnet(network) => Some(network),
            _ => None,
        }
    }

    /// The experiment whose images it is evaluated on.
    pub(crate) fn experiment(&self, stages: &Stages) -> BodyConfig {
        let mut config = match self.images {
            Images::Eros => Network::Scratch,
            Images::FixedCount => Network::FixedCount,
            Images::Pim => Network::Pim,
            Images::Grey => Network::Grey,
        }
        .config(stages);
        // The blur is for networks that were trained with it.
        if matches!(self.weights, Weights::File(_)) {
            config.image.blur = None;
        }
        config
    }

    pub(crate) fn figure(&self, measure: &str, data_set: DataSet) -> Option<f64> {
        let mut figures = self.published.iter();
        let is_it = |figure: &&Figure| figure.measure == measure && figure.data_set == data_set;
        figures.find(is_it).map(|figure| figure.value)
    }
}

impl Images {
    /// In a table.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Eros => "EROS",
            Self::FixedCount => "7500 events",
            Self::Pim => "PIM",
            Self::Grey => "grey",
        }
    }
}

impl FileKind {
    /// How the file is given, and where one comes from.
    pub(crate) fn how_to_get(self) -> &'static str {
        match self {
            Self::OpenPose => {
                "give --openpose FILE.onnx: a COCO or BODY_25 network of OpenPose, or lightweight OpenPose, \
                 exported to ONNX"
            }
            Self::MoveNet => {
                "give --movenet FILE.onnx: MoveNet SinglePose Lightning or Thunder, converted to ONNX by tf2onnx"
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_one_of_a_kind_and_figures_are_given_once() {
        for system in &SYSTEMS {
            assert_eq!(selected(&SYSTEMS, &[system.name.to_owned()]).len(), 1, "{}", system.name);
            for figure in system.published {
                let same = |other: &&Figure| {
                    other.measure == figure.measure && other.data_set == figure.data_set
                };
                assert_eq!(system.published.iter().filter(same).count(), 1, "{}", system.name);
            }
        }
        assert_eq!(selected(&SYSTEMS, &[]).len(), SYSTEMS.len());
    }
}
