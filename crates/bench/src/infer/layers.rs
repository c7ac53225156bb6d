//! Time per layer of a network.

use evpose_infer::Engine;
use serde::Serialize;

use evpose_cli::latency;
use evpose_core::stats::quantile::nearest_rank;

/// Runs per layer, for a median.
const RUNS: usize = 25;

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
    /// The same over what the processor can do at best.
    of_peak: f64,
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
    let layers = engine.layers().iter().enumerate().map(|(k, layer)| {
        let mut times_s: Vec<f64> = runs.iter().map(|run| run[k].as_secs_f64()).collect();
        times_s.sort_by(f64::total_cmp);
        let median_s = nearest_rank(&times_s, 0.5);
        let gflop_per_s = 2e-9 * layer.macs as f64 / median_s;
        LayerTime {
            name: layer.name.clone(),
            algorithm: layer.algorithm,
            output: layer.output,
            macs_m: layer.macs as f64 / 1e6,
            // Every value is moved once, from or to memory.
            flop_per_byte: 2.0 * layer.macs as f64 / layer.bytes as f64,
            median_ms: median_s * 1e3,
            gflop_per_s,
            of_peak: gflop_per_s / peak,
        }
    });
    layers.collect()
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
            "{:34} {:11} {:>12} {:8.1} {:8.3} {:8.1} {:5.0} %",
            layer.name,
            layer.algorithm,
            format!("{channels}x{height}x{width}"),
            layer.macs_m,
            layer.median_ms,
            layer.gflop_per_s,
            100.0 * layer.of_peak
        )
    };
    std::iter::once(head).chain(layers.iter().map(line)).collect()
}
