//! Networks to measure.

use anyhow::{Context as _, Result, ensure};
use burn::tensor::Device;
use evpose_infer::{Engine, EngineOptions};
use evpose_nn::graph::Graph;
use evpose_nn::parameters::{fill, read};
use evpose_nn::{
    HandHead, JOINT_NET, MOVE_ENET, MoveEnet, Network as Module, NnError, backbone_by_name,
};
use evpose_task::hand::HandConfig;
use evpose_train::untrained;

use super::start::StartTime;
use evpose_cli::latency::{self, Runner};
use evpose_cli::progress::note;

/// Maximum of a body network's input.
const BRIGHT: f32 = 255.0;
/// Name that selects every network of the registry.
const ALL: &str = "all";

/// A network with initial weights, and running statistics to match.
pub(super) struct Network {
    pub(super) name: String,
    pub(super) width: f32,
    pub(super) parameters: usize,
    /// Channels, rows and columns.
    pub(super) input: [usize; 3],
    pub(super) graph: Graph,
    /// The Burn module.
    pub(super) module: Module,
}

impl Network {
    pub(super) fn burn<'a>(&'a self, device: &'a Device) -> Runner<'a> {
        // Reading values back waits for the computation.
        let forward = |images| drop(std::hint::black_box(self.module.outputs(images)));
        Runner::Burn(Box::new(forward), device)
    }

    /// Measures the time from a checkpoint to the first pose.
    ///
    /// # Errors
    /// If weights cannot be written or read.
    pub(super) fn start(&self, options: EngineOptions) -> Result<StartTime> {
        StartTime::measure(&self.module, self.input, options)
    }

    pub(super) fn image(&self, seed: u64) -> Vec<f32> {
        let [channels, height, width] = self.input;
        let mut image = latency::windows([1, channels, height, width], seed);
        image.iter_mut().for_each(|value| *value *= self.module.max_input());
        image
    }
}

/// Names of the selected networks; by default that of the config.
///
/// # Errors
/// If one is not in the registry.
pub(super) fn names(config: &HandConfig, asked: &[String]) -> Result<Vec<String>> {
    if asked.is_empty() {
        return Ok(vec![match config.network.head {
            HandHead::Regressor => config.network.backbone.clone(),
            HandHead::Joints => JOINT_NET.to_owned(),
        }]);
    }
    if asked.iter().any(|name| name == ALL) {
        // It would name the others twice.
        ensure!(asked.len() == 1, "`--network {ALL}` leaves nothing to add");
        return Ok(Module::names().filter(|name| fits(config, name)).map(str::to_owned).collect());
    }
    let called = |name: &String| {
        let known = || Module::names().collect::<Vec<_>>().join(", ");
        let unknown = || NnError::UnknownNetwork { name: name.clone(), known: known() };
        let name = Module::names().find(|known| known == name).ok_or_else(unknown)?;
        Ok(name.to_owned())
    };
    asked.iter().map(called).collect()
}

/// Whether a network takes images of the config's size; a note says which does not.
fn fits(config: &HandConfig, name: &str) -> bool {
    let smallest_px = backbone_by_name(name).map_or(0, |backbone| backbone.smallest_px);
    let size = config.network_size();
    let fits = usize::from(size.width.min(size.height)) >= smallest_px;
    if !fits {
        note(format!(
            "note: {name} needs {smallest_px} pixels along each side, images have {size}"
        ));
    }
    fits
}

/// The network of a config with another backbone, or of joints; MoveEnet with images as published.
pub(super) fn network(config: &HandConfig, name: &str, device: &Device) -> Result<Network> {
    let width = config.network.width;
    let (module, input) = if name == MOVE_ENET {
        let module = Module::untrained(name, width, config.seed, device)?;
        let input = module.input();
        (module, input)
    } else if name == JOINT_NET {
        let module = Module::untrained(name, width, config.seed, device)?;
        // Sides of other images may be none that its pyramid has.
        let input = match config.network.head {
            HandHead::Joints => image_of(config),
            HandHead::Regressor => module.input(),
        };
        (module, input)
    } else {
        let mut config = config.clone();
        name.clone_into(&mut config.network.backbone);
        config.network.head = HandHead::Regressor;
        let network = untrained(&config, device)?.into_regressor().context("a regressor")?;
        let module = Module::Hand(Box::new(network));
        (module, image_of(&config))
    };
    // Initial variances of 1 let values vanish: outputs would agree whatever is computed.
    let module = match module.with_matched_variances() {
        Module::Body(network) => Module::Body(Box::new(moderate(*network, input)?)),
        module => module,
    };
    Ok(Network {
        name: name.to_owned(),
        width,
        parameters: module.parameter_count(),
        input,
        graph: module.graph(),
        module,
    })
}

/// Channels, rows and columns of the images of a config's network.
fn image_of(config: &HandConfig) -> [usize; 3] {
    let size = config.network_size();
    [2, usize::from(size.height), usize::from(size.width)]
}

/// A body's network whose maps are about one before their sigmoids, as those of a trained one:
/// residuals add up, and of thousands a sigmoid shows nothing but how they were rounded.
fn moderate(network: MoveEnet, input: [usize; 3]) -> Result<MoveEnet> {
    let mut engine = Engine::compile(&network.graph(), input, EngineOptions::default())?;
    let values = engine.run(&vec![BRIGHT; input.iter().product()]).iter().flatten();
    let largest = values.fold(1.0, |most: f32, value| most.max(value.abs()));
    let mut values = read(&network).into_iter();
    Ok(fill(network, |slot| {
        let (_, mut values) = values.next().unwrap_or_else(|| unreachable!("every slot is read"));
        if slot.path.ends_with("last.weight") {
            values.iter_mut().for_each(|value| *value /= largest);
        }
        values
    }))
}

#[cfg(test)]
mod tests {
    use evpose_nn::BACKBONES;

    use super::*;
    use crate::infer::against::max_difference;
    use evpose_cli::configs;

    #[test]
    fn outputs_differ_between_images() {
        let changes = ["simulation.image_scale=0.5", "network.width=0.25"].map(str::to_owned);
        let config: HandConfig = configs::load("eventhands", &changes).unwrap();
        for entry in &BACKBONES {
            let name = entry.name;
            let network = network(&config, name, &Device::flex()).unwrap();
            let options = EngineOptions::default();
            let mut engine = Engine::compile(&network.graph, network.input, options).unwrap();
            let [one, other] = [1, 2].map(|seed| engine.run(&network.image(seed)).to_vec());
            let difference = max_difference(&one, &other);
            assert!(difference > 0.01, "{name}: {difference}");
        }
    }
}
