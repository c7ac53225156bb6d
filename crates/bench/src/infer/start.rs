//! Start-up time: from a checkpoint on disk to the first pose.

use std::time::Instant;

use anyhow::{Context, Result};
use burn::tensor::Device;
use evpose_infer::{Engine, EngineOptions};
use evpose_nn::weights::{BodyCard, ModelCard, load, save};
use evpose_nn::{HandNetwork, HandRegressor, MoveEnet, Network};
use evpose_pose::body::{BodyDecoder, BodyMaps, DEFAULT_THRESHOLD};
use serde::Serialize;

use evpose_cli::progress::say;
use evpose_core::stats::quantile::nearest_rank;

/// Repetitions; the first one brings the file into the page cache.
const STARTS: usize = 5;
/// Stride of the output maps in pixels.
const MAP_STRIDE: usize = 4;

/// Median start-up times.
#[derive(Debug, Serialize)]
pub(super) struct StartTime {
    weights_ms: f64,
    compile_ms: f64,
    /// First inference, decoding included.
    first_ms: f64,
    all_ms: f64,
}

impl StartTime {
    /// Writes the weights of a network to a file and measures the start-up from there.
    ///
    /// # Errors
    /// If they cannot be written or read again.
    pub(super) fn measure(
        network: &Network,
        input: [usize; 3],
        options: EngineOptions,
    ) -> Result<Self> {
        let folder = tempfile::tempdir().context("making a folder for a checkpoint")?;
        let path = folder.path().join("weights.bpk");
        match network {
            Network::Hand(network) => save(&path, &**network, &ModelCard::default())?,
            Network::Body(network) => save(&path, &**network, &BodyCard::default())?,
            Network::Joints(network) => {
                save(&path, &HandNetwork::Joints((**network).clone()), &ModelCard::default())?;
            }
        }
        // Values do not change the time of a first inference.
        let image = vec![0.5; input.iter().product()];
        let mut times_ms: [Vec<f64>; 4] = Default::default();
        for _ in 0..STARTS {
            let begin = Instant::now();
            let graph = match network {
                Network::Hand(_) => load::<HandRegressor>(&path, &Device::flex())?.0.graph(),
                Network::Body(_) => load::<MoveEnet>(&path, &Device::flex())?.0.graph(),
                Network::Joints(_) => load::<HandNetwork>(&path, &Device::flex())?.0.graph(),
            };
            let read = begin.elapsed();
            let mut engine = Engine::compile(&graph, input, options)?;
            let compiled = begin.elapsed();
            let outputs = engine.run(&image);
            if let [heatmaps, centers, regs, offsets] = outputs {
                let maps = [heatmaps, centers, regs, offsets].map(Vec::as_slice);
                let cells = [input[1], input[2]].map(|side| side / MAP_STRIDE);
                let decoder = BodyDecoder::new(cells, DEFAULT_THRESHOLD);
                // The first pose, not the first maps.
                std::hint::black_box(decoder.decode(&BodyMaps::from_array(maps)));
            }
            let done = begin.elapsed();
            // Readings are cumulative: parts are their differences, and the last is the whole.
            let times = [read, compiled - read, done - compiled, done];
            let ms = times.map(|time| time.as_secs_f64() * 1e3);
            times_ms.iter_mut().zip(ms).for_each(|(all, ms)| all.push(ms));
        }
        let [weights_ms, compile_ms, first_ms, all_ms] = times_ms.map(|mut times| {
            times.sort_by(f64::total_cmp);
            nearest_rank(&times, 0.5)
        });
        Ok(Self { weights_ms, compile_ms, first_ms, all_ms })
    }

    /// Prints the times.
    pub(super) fn say(&self) {
        say(format!(
            "start     {:.0} ms from a checkpoint to the first pose: weights {:.0}, compiling {:.0}, first \
             image {:.0}",
            self.all_ms, self.weights_ms, self.compile_ms, self.first_ms
        ));
    }
}
