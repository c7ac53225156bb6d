//! The networks that are measured.

use anyhow::{Result, ensure};
use burn::module::Module as _;
use burn::tensor::Device;
use evpose_nn::graph::Graph;
use evpose_nn::{BACKBONES, HandRegressor, backbone_called};
use evpose_train::{HandConfig, untrained};

/// All of the registry.
const ALL: &str = "all";

/// A network with first weights.
pub(super) struct Network {
    pub(super) name: String,
    pub(super) width: f32,
    pub(super) parameters: usize,
    /// Channels, rows and columns.
    pub(super) input: [usize; 3],
    pub(super) graph: Graph,
    /// As Burn has it.
    pub(super) module: HandRegressor,
}

/// The names that were asked for: the config's own without any.
///
/// # Errors
/// If one is not in the registry.
pub(super) fn names(config: &HandConfig, asked: &[String]) -> Result<Vec<String>> {
    if asked.is_empty() {
        return Ok(vec![config.network.backbone.clone()]);
    }
    if asked.iter().any(|name| name == ALL) {
        ensure!(asked.len() == 1, "`--network {ALL}` leaves nothing to add");
        return Ok(BACKBONES.iter().map(|entry| entry.name.to_owned()).collect());
    }
    asked.iter().map(|name| Ok(backbone_called(name)?.name.to_owned())).collect()
}

/// The network of a config with another backbone.
pub(super) fn network(config: &HandConfig, name: &str, device: &Device) -> Result<Network> {
    let mut config = config.clone();
    name.clone_into(&mut config.network.backbone);
    let module = untrained(&config, device)?;
    let size = config.simulation.image_size();
    Ok(Network {
        name: name.to_owned(),
        width: config.network.width,
        parameters: module.num_params(),
        input: [2, usize::from(size.height), usize::from(size.width)],
        graph: module.graph(),
        module,
    })
}
