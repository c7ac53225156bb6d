//! Finished networks of bodies on disk, with everything needed to use them.

use std::path::Path;

use burn::tensor::Device;
use evpose_nn::MoveEnet;
use evpose_nn::weights::{self, BodyCard};
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use glam::Vec2;

use super::config::BodyConfig;
use crate::{Experiment as _, TaskError, network_file};

/// Keys of the provenance in a weight file.
const CONFIG: &str = "config";
const MEAN_POSE: &str = "mean_pose";
const DATA: &str = "data";

/// A network of bodies together with the experiment it came from.
#[derive(Debug)]
pub struct BodyCheckpoint {
    /// The experiment; the published setting for weights from elsewhere.
    pub config: BodyConfig,
    /// Network with its weights.
    pub network: MoveEnet,
    /// Mean of the poses it was trained on, relative to the image; not known for weights from
    /// elsewhere.
    pub mean_pose: Option<BodyPoints>,
    /// Digest of the data that it was trained on.
    pub data: Option<String>,
}

impl BodyCheckpoint {
    /// Writes one self-describing file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), TaskError> {
        let mut card = BodyCard { network: self.network.config().clone(), ..BodyCard::default() };
        card.provenance.insert(CONFIG.to_owned(), self.config.to_toml()?);
        if let Some(mean) = &self.mean_pose {
            card.provenance.insert(MEAN_POSE.to_owned(), pose_as_text(mean));
        }
        if let Some(data) = &self.data {
            card.provenance.insert(DATA.to_owned(), data.clone());
        }
        Ok(weights::save(path, &self.network, &card)?)
    }

    /// Reads a run directory (its best network), a `.bpk` file, or the published PyTorch weights
    /// (`.pth`).
    ///
    /// # Errors
    /// If there is no network at `path`, or it is damaged or of another shape than it says.
    pub fn load(path: &Path, device: &Device) -> Result<Self, TaskError> {
        let path = &network_file(path)?;
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        if ["pth", "pt", "ckpt"].iter().any(|known| extension == *known) {
            let config = BodyConfig::default();
            let network = weights::load_move_enet(path, &config.network, device)?;
            return Ok(Self { config, network, mean_pose: None, data: None });
        }
        let (network, card) = weights::load::<MoveEnet>(path, device)?;
        let config = match card.provenance.get(CONFIG) {
            Some(text) => BodyConfig::parse(text, &[])?,
            // A file without a config still knows the shape of its network.
            None => BodyConfig { network: card.network, ..BodyConfig::default() },
        };
        let mean_pose = card.provenance.get(MEAN_POSE).and_then(|text| pose_from_text(text));
        Ok(Self { config, network, mean_pose, data: card.provenance.get(DATA).cloned() })
    }
}

/// A pose as weight files keep it: x and y of every joint, dashes where it is not known.
pub(crate) fn pose_as_text(pose: &BodyPoints) -> String {
    let joint = |joint: &Option<Vec2>| match joint {
        Some(at) => format!("{} {}", at.x, at.y),
        None => "- -".to_owned(),
    };
    let joints: Vec<String> = pose.iter().map(joint).collect();
    joints.join(" ")
}

/// The pose of a text of [`pose_as_text`]; none if it is another.
pub(crate) fn pose_from_text(text: &str) -> Option<BodyPoints> {
    let values: Vec<Option<f32>> = text.split(' ').map(|value| value.parse().ok()).collect();
    let pairs = values.as_chunks::<2>().0;
    (pairs.len() == BODY_JOINTS).then(|| {
        std::array::from_fn(|joint| {
            let [x, y] = pairs[joint];
            Some(Vec2::new(x?, y?))
        })
    })
}
