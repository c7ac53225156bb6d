//! `evpose export`: a network as an ONNX file.

use anyhow::{Context, Result};
use burn::tensor::Device;
use evpose_core::atomic_write;
use evpose_onnx::{Message as _, OPSET, model};
use evpose_task::hand::HandCheckpoint;
use evpose_train::untrained;

use evpose_app::hand_config;
use evpose_app::progress::say;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose export --checkpoint runs/hand --onnx hand.onnx\n  \
    evpose export eventhands --set network.backbone=mobilenet_v2 --onnx untrained.onnx")]
pub(crate) struct ExportArgs {
    /// A TOML file, or an embedded config: its network with first weights, for the size of its images
    #[arg(required_unless_present = "checkpoint", conflicts_with = "checkpoint")]
    pub(crate) config: Option<String>,
    /// Change one field, for example --set network.width=0.5 (may be repeated)
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "config")]
    pub(crate) overrides: Vec<String>,
    /// A trained network instead: a run directory, or a .bpk file with its .toml beside it
    #[arg(long)]
    pub(crate) checkpoint: Option<PathBuf>,
    /// The file to write
    #[arg(long)]
    pub(crate) onnx: PathBuf,
}

pub(crate) fn run(args: &ExportArgs) -> Result<()> {
    let device = Device::flex();
    let (config, network) = match (&args.checkpoint, &args.config) {
        (Some(path), _) => {
            let checkpoint = HandCheckpoint::load(path, &device)?;
            (checkpoint.config, checkpoint.network)
        }
        (None, source) => {
            let source = source.as_deref().context("a config or a checkpoint")?;
            let config = hand_config::load(source, &args.overrides)?;
            let network = untrained(&config, &device)?;
            (config, network)
        }
    };
    let size = config.simulation.image_size();
    let [height, width] = [size.height, size.width].map(usize::from);
    let graph = network.graph();
    let channels = graph.nodes[0].channels;
    let model = model(&graph, [channels, height, width])?;
    let bytes = model.encode_to_vec();
    atomic_write(&args.onnx, &bytes).with_context(|| format!("writing {}", args.onnx.display()))?;
    let nodes = model.graph.map_or(0, |graph| graph.node.len());
    say(format!(
        "{}: {} of width {}, input 1x{channels}x{height}x{width}, {nodes} operators of ONNX's set \
         {OPSET}, {:.1} MB",
        args.onnx.display(),
        config.network.backbone,
        config.network.width,
        bytes.len() as f64 / 1e6
    ));
    Ok(())
}
