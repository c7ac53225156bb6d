//! `evpose export`: a network as an ONNX file.

use std::path::PathBuf;

use crate::args::{ConfigArgs, DeviceArgs};
use crate::outputs::{OutputFile, write_file};
use crate::progress::say;
use crate::shipped::checkpoint_sha256;
use crate::tasks::{open, task_of_config};
use anyhow::{Context, Result};
use burn::tensor::Device;
use evpose_infer::onnx::{BATCH, Message as _, OPSET, model};
use evpose_nn::DeviceKind;

/// Arguments of `evpose export`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose export --checkpoint runs/hand --onnx hand.onnx\n  \
    evpose export --checkpoint body --onnx body.onnx\n  \
    evpose export eventhands --set network.backbone=mobilenet_v2 --onnx untrained.onnx")]
pub struct ExportArgs {
    /// A TOML file, or an embedded config: export its network with initial weights
    #[arg(required_unless_present = "checkpoint", conflicts_with = "checkpoint")]
    pub(crate) config: Option<String>,
    /// Change one field, for example --set network.width=0.5 (may be repeated)
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "config")]
    pub(crate) overrides: Vec<String>,
    /// Export a trained network: a run directory, a .bpk file, or the name of a shipped network
    #[arg(long)]
    pub(crate) checkpoint: Option<PathBuf>,
    /// The ONNX file to write
    #[arg(long)]
    pub(crate) onnx: OutputFile,
}

/// Runs `evpose export`.
pub fn run(args: &ExportArgs) -> Result<()> {
    let pose_model = match (&args.checkpoint, &args.config) {
        (Some(path), _) => {
            // Weights are only read and written: the CPU, which every build has, is enough.
            let device = DeviceArgs { device: DeviceKind::Flex, threads: None };
            open(path, &device)?
        }
        (None, source) => {
            let config = source.clone().context("a config or a checkpoint")?;
            let config = ConfigArgs { config, overrides: args.overrides.clone() };
            task_of_config(&config.config)?.studied()?.untrained(&config, &Device::flex())?
        }
    };
    let network = pose_model.network()?;
    let [channels, height, width] = network.input_shape();
    let mut interface = network.interface();
    let digest = args.checkpoint.as_deref().map(checkpoint_sha256).transpose()?;
    let known = [
        ("task", pose_model.task().to_owned()),
        ("network", network.network_name()),
        ("evpose_version", env!("CARGO_PKG_VERSION").to_owned()),
        ("checkpoint_sha256", digest.unwrap_or_else(|| "untrained".to_owned())),
        ("config", pose_model.config_toml()?),
    ];
    interface.metadata.extend(known.map(|(key, value)| (key.to_owned(), value)));
    let model = model(&network.graph(), [channels, height, width], Some(&interface))?;
    let bytes = model.encode_to_vec();
    // Whole or not at all, so that an aborted export leaves no file that looks like a network.
    write_file(&args.onnx, &bytes)?;
    let nodes = model.graph.map_or(0, |graph| graph.node.len());
    say(format!(
        "{}: {}, input {BATCH}x{channels}x{height}x{width}, {nodes} operators of opset {OPSET}, {:.1} MB",
        args.onnx.display(),
        network.network_name(),
        bytes.len() as f64 / 1e6
    ));
    Ok(())
}
