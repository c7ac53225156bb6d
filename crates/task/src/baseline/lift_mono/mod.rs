//! LiftMono-HPE alone: the published setting, the weights as its code writes them, joints with depths.
//!
//! # Source
//! Scarpellini et al.: *Lifting Monocular Events to 3D Human Poses*, CVPRW 2021, and its published configs.

mod geometry;

use std::path::{Path, PathBuf};

use burn::tensor::Device;
use evpose_nn::{BaselineNetwork, BaselineNetworkConfig, LiftMonoConfig, weights};
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use glam::Vec2;

use super::config::{BaselineConfig, BaselineImageConfig, BaselineLossConfig};
use crate::TaskError;
use crate::body::BodyTrainingConfig;
use crate::schedule::Schedule;

pub use geometry::{LiftGeometry, torso_m};

/// Columns and rows of the input, as published for DHP19's cameras.
const SIZE_PX: [usize; 2] = [346, 260];
/// The torso of LiftMono-HPE in metres, the mean of DHP19's people.
pub const PUBLISHED_TORSO_M: f32 = 0.453_524_23;
/// The depths of LiftMono-HPE in metres.
pub(super) const PUBLISHED_DEPTHS_M: [f32; 2] = [2.0, 5.0];

impl BaselineConfig {
    /// LiftMono-HPE as published: three stages, Adam at 3e-4, a tenth of it after every tenth of
    /// the training.
    pub fn lift_mono() -> Self {
        let [width_px, height_px] = SIZE_PX;
        let dhp19 = Self::default();
        let milestones = (1..10).map(|tenth| 0.1 * f64::from(tenth)).collect();
        Self {
            out: PathBuf::from("runs/body/lift-mono"),
            image: BaselineImageConfig { width_px, height_px, ..dhp19.image },
            network: BaselineNetworkConfig::LiftMono(LiftMonoConfig::default()),
            loss: BaselineLossConfig { sigma_px: 1.0 },
            training: BodyTrainingConfig {
                batch_size: 32,
                learning_rate: 3e-4,
                schedule: Schedule { milestones, ..Schedule::default() },
                ..dhp19.training
            },
            ..dhp19
        }
    }
}

/// The network as its code writes it.
pub(super) fn load(path: &Path, device: &Device) -> Result<BaselineNetwork, TaskError> {
    let network = weights::load_lift_mono(path, &LiftMonoConfig::default(), device)?;
    Ok(BaselineNetwork::LiftMono(network))
}

/// Joints of expected positions, -1 to 1, relative to the input, and their depths.
pub(super) fn expected(positions: &[f32]) -> (BodyPoints, [f32; BODY_JOINTS]) {
    let (mut points, mut depths) = (BodyPoints::default(), [0.0; BODY_JOINTS]);
    for (joint, [x, y, z]) in positions.as_chunks::<3>().0.iter().enumerate().take(BODY_JOINTS) {
        points[joint] = Some(0.5 * (Vec2::new(*x, *y) + 1.0));
        depths[joint] = *z;
    }
    (points, depths)
}
