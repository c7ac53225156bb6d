//! Finished baselines on disk, with everything needed to use them.

use std::path::Path;

use burn::tensor::Device;
use evpose_nn::BaselineNetwork;
use evpose_nn::weights::{self, BaselineCard};
use evpose_pose::body::BodyPoints;

use super::config::BaselineConfig;
use super::{dhp19, lift_mono};
use crate::body::{pose_as_text, pose_from_text};
use crate::{Experiment as _, TaskError, network_file};

/// Keys of the provenance in a weight file.
const CONFIG: &str = "config";
const TORSO: &str = "torso_m";
const DEPTHS: &str = "depths_m";
const MEAN_POSE: &str = "mean_pose";
const DATA: &str = "data";

/// A baseline together with the experiment it came from.
#[derive(Debug, Clone)]
pub struct BaselineCheckpoint {
    /// The experiment; the published setting for weights from elsewhere.
    pub config: BaselineConfig,
    /// Network with its weights.
    pub network: BaselineNetwork,
    /// Mean torso of the people it was trained on, in metres, by which joints in three dimensions
    /// are scaled; none where it is not known.
    pub torso_m: Option<f32>,
    /// The smallest and the largest depth of their heads in metres, between which people are
    /// placed; none where they are not known.
    pub depths_m: Option<[f32; 2]>,
    /// Mean of the poses it was trained on, relative to the image; not known for weights from
    /// elsewhere.
    pub mean_pose: Option<BodyPoints>,
    /// Digest of the data that it was trained on.
    pub data: Option<String>,
}

impl BaselineCheckpoint {
    /// Writes one self-describing file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), TaskError> {
        let mut card = BaselineCard { network: self.network.config(), ..BaselineCard::default() };
        let mut add = |key: &str, value: Option<String>| {
            value.map(|value| card.provenance.insert(key.to_owned(), value));
        };
        add(CONFIG, Some(self.config.to_toml()?));
        add(TORSO, self.torso_m.map(|torso_m| torso_m.to_string()));
        add(DEPTHS, self.depths_m.map(|[nearest, farthest]| format!("{nearest} {farthest}")));
        add(MEAN_POSE, self.mean_pose.as_ref().map(pose_as_text));
        add(DATA, self.data.clone());
        Ok(weights::save(path, &self.network, &card)?)
    }

    /// Reads a run directory (its best network), a `.bpk` file, the distributed weights of DHP19's
    /// network (`DHP_CNN.model`, or another ending of HDF5), or those of LiftMono-HPE as its code
    /// writes them (`.ckpt`, `.pth`).
    ///
    /// # Errors
    /// If there is no network at `path`, or it is damaged or of another shape than it says.
    pub fn load(path: &Path, device: &Device) -> Result<Self, TaskError> {
        let path = &network_file(path)?;
        let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
        match ending.to_str() {
            Some("model" | "h5" | "hdf5") => {
                let (config, network) = (BaselineConfig::dhp19_cnn(), dhp19::load(path, device)?);
                return Ok(Self::from_elsewhere(config, network, None));
            }
            Some("ckpt" | "pth" | "pt") => {
                let network = lift_mono::load(path, device)?;
                let people = Some((lift_mono::PUBLISHED_TORSO_M, lift_mono::PUBLISHED_DEPTHS_M));
                return Ok(Self::from_elsewhere(BaselineConfig::lift_mono(), network, people));
            }
            _ => {}
        }
        let (network, card) = weights::load::<BaselineNetwork>(path, device)?;
        let value = |key: &str| card.provenance.get(key);
        let config = match value(CONFIG) {
            Some(text) => BaselineConfig::parse(text, &[])?,
            // A file without a config still knows the shape of its network.
            None => BaselineConfig { network: network.config(), ..BaselineConfig::default() },
        };
        Ok(Self {
            config,
            torso_m: value(TORSO).and_then(|text| text.parse().ok()),
            depths_m: value(DEPTHS).and_then(|text| {
                let (nearest, farthest) = text.split_once(' ')?;
                Some([nearest.parse().ok()?, farthest.parse().ok()?])
            }),
            mean_pose: value(MEAN_POSE).and_then(|text| pose_from_text(text)),
            data: value(DATA).cloned(),
            network,
        })
    }

    fn from_elsewhere(
        config: BaselineConfig,
        network: BaselineNetwork,
        people: Option<(f32, [f32; 2])>,
    ) -> Self {
        let (torso_m, depths_m) = people.unzip();
        Self { config, network, torso_m, depths_m, mean_pose: None, data: None }
    }
}

#[cfg(test)]
mod tests {
    use evpose_nn::{BaselineNetworkConfig, LiftMonoConfig};
    use evpose_pose::body::BODY_JOINTS;
    use glam::Vec2;

    use super::*;
    use crate::BEST;

    #[test]
    fn a_checkpoint_comes_back_with_everything_it_knows() {
        let (folder, device) = (tempfile::tempdir().unwrap(), Device::flex());
        let network = LiftMonoConfig { width: 0.0625, stages: 1, ..LiftMonoConfig::default() };
        let network = BaselineNetworkConfig::LiftMono(network);
        let mut config = BaselineConfig::lift_mono().with_size(64, 48);
        config.network = network.clone();
        let mut mean_pose = [Some(Vec2::new(0.25, 0.5)); BODY_JOINTS];
        mean_pose[4] = None;
        let saved = BaselineCheckpoint {
            config,
            network: network.init(3, &device).unwrap(),
            torso_m: Some(0.47),
            depths_m: Some([1.5, 6.25]),
            mean_pose: Some(mean_pose),
            data: Some("digest".to_owned()),
        };
        let path = folder.path().join(BEST);
        saved.save(&path).unwrap();
        let back = BaselineCheckpoint::load(folder.path(), &device).unwrap();
        assert_eq!(back.config, saved.config);
        assert_eq!((back.torso_m, back.depths_m), (saved.torso_m, saved.depths_m));
        assert_eq!(back.mean_pose, saved.mean_pose);
        assert_eq!((back.data, back.network.config()), (saved.data, network));
    }

    #[test]
    fn a_directory_without_a_network_says_what_to_give() {
        let folder = tempfile::tempdir().unwrap();
        let error = BaselineCheckpoint::load(folder.path(), &Device::flex()).unwrap_err();
        assert!(error.to_string().contains("no best.bpk here: a run writes it"), "{error}");
    }
}
