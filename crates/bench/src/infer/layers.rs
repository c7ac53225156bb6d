//! Time per layer of a network.

use burn::tensor::{Device, Tensor, TensorData};
use evpose_infer::{Engine, Layer};
use evpose_nn::graph::{Node, Operation};
use serde::Serialize;

use super::networks::Network;
use evpose_cli::latency;
use evpose_core::stats::quantile::nearest_rank;

/// Runs per layer, for a median.
pub(super) const RUNS: usize = 25;

#[derive(Debug, Serialize)]
pub(crate) struct LayerTime {
    name: String,
    algorithm: &'static str,
    /// Channels, rows and columns of the output.
    output: [usize; 3],
    /// Millions of multiply-accumulates of the layer as defined.
    macs_m: f64,
    /// Operations over bytes of weights, inputs and output, each moved once.
    pub(crate) flop_per_byte: f64,
    median_ms: f64,
    /// Of the layer as defined: an algorithm with fewer MACs may exceed the peak of the processor
    /// can do.
    pub(crate) gflop_per_s: f64,
    /// The same over what the processor can do at best, where that is known.
    of_peak: Option<f64>,
}

impl LayerTime {
    /// `times_s` are those of several runs.
    fn new(layer: &Layer, mut times_s: Vec<f64>, peak: Option<f64>) -> Self {
        times_s.sort_by(f64::total_cmp);
        let median_s = nearest_rank(&times_s, 0.5);
        let gflop_per_s = 2e-9 * layer.macs as f64 / median_s;
        Self {
            name: layer.name.clone(),
            algorithm: layer.algorithm,
            output: layer.output,
            macs_m: layer.macs as f64 / 1e6,
            // Every value is moved once, from or to memory.
            flop_per_byte: 2.0 * layer.macs as f64 / layer.bytes as f64,
            median_ms: median_s * 1e3,
            gflop_per_s,
            of_peak: peak.map(|peak| gflop_per_s / peak),
        }
    }
}

/// Times every layer. `peak` is what the processor can do at best, in GFLOP/s.
pub(super) fn timed(
    engine: &mut Engine,
    [channels, height, width]: [usize; 3],
    seed: u64,
    peak: f64,
) -> Vec<LayerTime> {
    let windows = latency::windows([1, channels, height, width], seed);
    // Layers are timed within whole inferences: alone, their inputs would be in the cache.
    let runs: Vec<_> = (0..RUNS).map(|_| engine.run_timed(&windows)).collect();
    let times = |k: usize| runs.iter().map(|run| run[k].as_secs_f64()).collect();
    let layers = engine.layers().iter().enumerate();
    layers.map(|(k, layer)| LayerTime::new(layer, times(k), Some(peak))).collect()
}

/// Times every layer of Burn's network on `device`, as often as `runs` says.
pub(super) fn of_burn(
    network: &Network,
    batch: usize,
    seed: u64,
    runs: usize,
    device: &Device,
) -> Vec<LayerTime> {
    let [channels, height, width] = network.input;
    let shape = [batch, channels, height, width];
    let images = TensorData::new(latency::windows(shape, seed), shape);
    let images = Tensor::<4>::from_data(images, device);
    let runs: Vec<_> = (0..runs).map(|_| network.module.node_times(images.clone())).collect();
    let mut sizes = vec![network.input];
    sizes.extend(runs[0].iter().map(|node| node.output));
    let of = |(k, node): (usize, &Node)| {
        let times_s = runs.iter().map(|run| run[k].time.as_secs_f64()).collect();
        LayerTime::new(&layer(node, &sizes, sizes[k + 1], batch), times_s, None)
    };
    network.graph.nodes[1..].iter().enumerate().map(of).collect()
}

/// A node of a graph with the sizes of all nodes, for a whole batch.
fn layer(node: &Node, sizes: &[[usize; 3]], output: [usize; 3], batch: usize) -> Layer {
    let values = |size: [usize; 3]| size.iter().product::<usize>() as u64;
    let (weights, macs) = match &node.operation {
        Operation::Conv(conv) => {
            let weights = conv.weight.len() as u64;
            (weights, weights * values([1, output[1], output[2]]))
        }
        Operation::Linear(linear) => [linear.weight.len() as u64; 2].into(),
        _ => (0, 0),
    };
    let inputs: u64 = node.inputs.iter().map(|input| values(sizes[*input])).sum();
    let batch = batch as u64;
    Layer {
        name: node.name.clone(),
        algorithm: "Burn",
        output,
        macs: batch * macs,
        weights,
        bytes: 4 * (weights + batch * (inputs + values(output))),
    }
}

pub(super) fn table(layers: &[LayerTime]) -> Vec<String> {
    if layers.is_empty() {
        return Vec::new();
    }
    let head = format!(
        "{:34} {:11} {:>12} {:>8} {:>8} {:>8} {:>7}",
        "layer", "algorithm", "output", "M MACs", "ms", "GFLOP/s", "of peak"
    );
    let line = |layer: &LayerTime| {
        let [channels, height, width] = layer.output;
        format!(
            "{:34} {:11} {:>12} {:8.1} {:8.3} {:8.1} {:>7}",
            layer.name,
            layer.algorithm,
            format!("{channels}x{height}x{width}"),
            layer.macs_m,
            layer.median_ms,
            layer.gflop_per_s,
            layer.of_peak.map_or_else(String::new, |of| format!("{:.0} %", 100.0 * of))
        )
    };
    std::iter::once(head).chain(layers.iter().map(line)).collect()
}
