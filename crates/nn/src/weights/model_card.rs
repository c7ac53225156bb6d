//! The descriptions that weight files carry.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize};

use crate::{BaselineNetworkConfig, HandRegressorConfig, MoveEnetConfig};

/// The network a weight file holds and the images it was made for, kept inside the file as TOML.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelCard {
    /// Architecture: backbone, width, outputs.
    pub network: HandRegressorConfig,
    /// The input that it was trained on.
    pub input: InputConfig,
    /// The origin of the weights, for people: configuration, seed, steps, commit.
    #[serde(default)]
    pub provenance: BTreeMap<String, String>,
}

/// The network of bodies that a weight file holds, kept inside the file as TOML.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyCard {
    /// Architecture: width, joints.
    pub network: MoveEnetConfig,
    /// The origin of the weights: configuration, mean pose, data.
    #[serde(default)]
    pub provenance: BTreeMap<String, String>,
}

/// The network of a baseline that a weight file holds, kept inside the file as TOML.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaselineCard {
    /// Architecture: DHP19's network or LiftMono-HPE.
    pub network: BaselineNetworkConfig,
    /// The origin of the weights: configuration, torso, data.
    #[serde(default)]
    pub provenance: BTreeMap<String, String>,
}

/// The event images a network was trained on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputConfig {
    /// Name of the representation.
    pub representation: String,
    /// Length of its window in microseconds.
    pub window_us: u64,
    /// `off-first` or `on-first`, as in configs; the shipped networks have an underscore.
    #[serde(deserialize_with = "hyphenated")]
    pub channel_order: String,
    /// Columns of the image shown to the network, which may be a reduced one.
    pub width_px: usize,
    /// Rows of it.
    pub height_px: usize,
}

/// A name in the spelling of configs.
fn hyphenated<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    Ok(String::deserialize(deserializer)?.replace('_', "-"))
}

impl Default for InputConfig {
    /// The published input: LNES of 100 ms on a DAVIS240C.
    fn default() -> Self {
        Self {
            representation: "lnes".to_owned(),
            window_us: 100_000,
            channel_order: "off-first".to_owned(),
            width_px: 240,
            height_px: 180,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cards_of_the_shipped_networks_are_the_same() {
        let text = toml::to_string(&InputConfig::default()).unwrap();
        assert!(text.contains("\"off-first\""), "{text}");
        let shipped = text.replace("off-first", "off_first");
        assert_eq!(toml::from_str::<InputConfig>(&shipped).unwrap(), InputConfig::default());
    }
}
