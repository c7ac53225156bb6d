//! Other runtimes, on the same network as an ONNX file.
//!
//! Each is configured for latency as its documentation recommends. [`Peer::run`] is what is timed: copies of
//! input and output are outside of it, and inside the timing of our engine.

#[cfg(feature = "peers")]
mod onnxruntime;
#[cfg(feature = "peers")]
mod openvino;
#[cfg(feature = "peers")]
mod tract;

use anyhow::Result;
use clap::ValueEnum;
use evpose_infer::Precision;

/// Runtimes to compare with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PeerName {
    /// ONNX Runtime, of the library in $ORT_DYLIB_PATH
    Onnxruntime,
    /// OpenVINO, of the library in $OPENVINO_DYLIB_PATH: f32 if ours is f32, else its default
    /// precision
    Openvino,
    /// OpenVINO in its default precision, which is bf16 where the processor has it
    OpenvinoDefault,
    /// tract, which is built in
    Tract,
}

/// A network in another runtime.
pub(super) trait Peer {
    /// Version of the runtime.
    fn version(&self) -> &str;

    /// Threads, precision and options of the runtime.
    fn settings(&self) -> &str;

    /// Maximum difference of outputs from ours, relative to the largest; `tolerance` is that of our
    /// precision.
    fn tolerance(&self, tolerance: f64) -> f64 {
        tolerance
    }

    /// Runs the network on its image, and copies nothing.
    fn run(&mut self) -> Result<()>;

    /// Runs the network and copies its outputs.
    fn outputs(&mut self) -> Result<Vec<Vec<f32>>>;
}

/// Input of a peer: network, image and settings.
#[cfg_attr(not(feature = "peers"), expect(dead_code, reason = "there are no peers"))]
pub(super) struct Job<'a> {
    /// The bytes of an ONNX file.
    pub(super) model: &'a [u8],
    /// Channels, rows and columns.
    pub(super) shape: [usize; 3],
    pub(super) image: &'a [f32],
    pub(super) threads: usize,
    /// Precision of our engine.
    pub(super) precision: Precision,
}

/// Makes a peer.
///
/// # Errors
/// If the program was built without peers, or the runtime's library cannot be loaded.
#[cfg(feature = "peers")]
pub(super) fn peer(name: PeerName, job: &Job<'_>) -> Result<Box<dyn Peer>> {
    Ok(match name {
        PeerName::Onnxruntime => Box::new(onnxruntime::OnnxRuntime::new(job)?),
        PeerName::Openvino => {
            Box::new(openvino::OpenVino::new(job, job.precision == Precision::F32)?)
        }
        PeerName::OpenvinoDefault => Box::new(openvino::OpenVino::new(job, false)?),
        PeerName::Tract => Box::new(tract::Tract::new(job)?),
    })
}

/// Makes a peer.
///
/// # Errors
/// Always: the program was built without peers.
#[cfg(not(feature = "peers"))]
pub(super) fn peer(_: PeerName, _: &Job<'_>) -> Result<Box<dyn Peer>> {
    anyhow::bail!("this program was built without other runtimes: build it with --features peers")
}

/// Path of a runtime's library, from an environment variable.
#[cfg(feature = "peers")]
fn library(variable: &str) -> Option<std::path::PathBuf> {
    std::env::var_os(variable).filter(|path| !path.is_empty()).map(Into::into)
}

#[cfg(all(test, feature = "peers"))]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use evpose_infer::{Engine, EngineOptions};
    use evpose_nn::Network;
    use evpose_task::hand::HandConfig;

    use super::*;
    use crate::infer::against::max_difference;
    use crate::infer::networks;

    /// Every network of the registry, at sizes that are and are not multiples of what they divide
    /// by. Inception leaves nothing of fewer than 75 rows.
    fn all_agree(name: PeerName) {
        for (backbone, scale) in Network::names().flat_map(|name| [(name, "1.0"), (name, "0.45")]) {
            let changes = [format!("simulation.image_scale={scale}"), "network.width=0.25".into()];
            let config: HandConfig = evpose_cli::configs::load("eventhands", &changes).unwrap();
            let network =
                networks::network(&config, backbone, &burn::tensor::Device::flex()).unwrap();
            let [_, height, width] = network.input;
            let image = network.image(3);
            let model = evpose_infer::onnx::encoded(&network.graph, network.input).unwrap();
            // Several threads split the work otherwise, which must not change the outputs.
            for threads in [1, 2] {
                let options = EngineOptions::default().with_threads(threads);
                let mut engine = Engine::compile(&network.graph, network.input, options).unwrap();
                let (shape, precision) = (network.input, Precision::F32);
                let job = Job { model: &model, shape, image: &image, threads, precision };
                let mut peer = peer(name, &job).unwrap();
                let difference = max_difference(engine.run(&image), &peer.outputs().unwrap());
                assert!(difference < 1e-4, "{backbone} {height}x{width}: {difference}");
            }
        }
    }

    #[test]
    fn every_network_agrees_with_tract() {
        all_agree(PeerName::Tract);
    }

    #[test]
    #[ignore = "needs the library of ONNX Runtime in $ORT_DYLIB_PATH"]
    fn every_network_agrees_with_onnx_runtime() {
        all_agree(PeerName::Onnxruntime);
    }

    #[test]
    #[ignore = "needs the library of OpenVINO in $OPENVINO_DYLIB_PATH"]
    fn every_network_agrees_with_openvino() {
        all_agree(PeerName::Openvino);
    }
}
