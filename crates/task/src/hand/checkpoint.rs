//! Finished networks on disk, with everything needed to use them.

use std::path::Path;

use burn::tensor::Device;
use evpose_nn::HandNetwork;
use evpose_nn::weights::{self, InputConfig, ModelCard};
use evpose_pose::HandParams;
use evpose_repr::ChannelOrder;

use super::config::HandConfig;
use super::predictor::NetworkPredictor;
use crate::{Experiment as _, TaskError, network_file};

/// Keys of the model card's provenance.
const CONFIG: &str = "config";
const MEAN_POSE: &str = "mean_pose";

/// A network together with the experiment it came from.
#[derive(Debug)]
pub struct HandCheckpoint {
    /// The experiment; the published setting for weights from elsewhere.
    pub config: HandConfig,
    /// Network with its weights.
    pub network: HandNetwork,
    /// Mean of the poses it was trained on; not known for weights from elsewhere.
    pub mean_pose: Option<HandParams>,
}

impl HandCheckpoint {
    /// Writes one self-describing file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), TaskError> {
        let sensor = self.config.network_size();
        let mut card = ModelCard {
            network: self.config.network.clone(),
            input: InputConfig {
                representation: self.config.representation.name.clone(),
                window_us: u64::from(self.config.representation.window_ms) * 1000,
                channel_order: match self.config.representation.channel_order {
                    ChannelOrder::OnFirst => "on-first".to_owned(),
                    ChannelOrder::OffFirst => "off-first".to_owned(),
                },
                width_px: sensor.width.into(),
                height_px: sensor.height.into(),
            },
            ..ModelCard::default()
        };
        card.provenance.insert(CONFIG.to_owned(), self.config.to_toml()?);
        if let Some(mean) = self.mean_pose {
            let values: Vec<String> = mean.to_array().iter().map(f32::to_string).collect();
            card.provenance.insert(MEAN_POSE.to_owned(), values.join(" "));
        }
        Ok(weights::save(path, &self.network, &card)?)
    }

    /// Its network on the CPU or another device.
    ///
    /// # Errors
    /// If the hand model that crops are found with cannot be read.
    pub fn predictor(&self, device: Device) -> Result<NetworkPredictor, TaskError> {
        NetworkPredictor::new(&self.config, self.network.clone(), device)
    }

    /// Reads a run directory (its best network), a `.bpk` file, or PyTorch weights of the published
    /// network (`.pth`, `.ckpt`).
    ///
    /// # Errors
    /// If there is no network at `path`, or it is damaged or of another shape than it says.
    pub fn load(path: &Path, device: &Device) -> Result<Self, TaskError> {
        let path = &network_file(path)?;
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        if extension == "pth" || extension == "ckpt" || extension == "pt" {
            let config = HandConfig::default();
            let network = weights::load_pytorch(path, &config.network, device)?;
            let network = HandNetwork::Regressor(network);
            return Ok(Self { config, network, mean_pose: None });
        }
        let (network, card) = weights::load::<HandNetwork>(path, device)?;
        let config = match card.provenance.get(CONFIG) {
            // The networks that ship were trained before configs named their task, and a file cannot be
            // changed without another training: of hands is what has the card of a hand network.
            Some(text) => HandConfig::parse(text, &["task=hand".to_owned()])?,
            None => HandConfig { network: card.network, ..HandConfig::default() },
        };
        let mean_pose = card.provenance.get(MEAN_POSE).and_then(|text| {
            let values: Vec<f32> = text.split(' ').filter_map(|n| n.parse().ok()).collect();
            Some(HandParams::from_array(values.try_into().ok()?))
        });
        Ok(Self { config, network, mean_pose })
    }
}
