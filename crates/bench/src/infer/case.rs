//! Measurement of one network in one setting.

use anyhow::Result;
use burn::tensor::Device;
use evpose_infer::{Engine, EngineOptions, Level, Precision};
use serde::Serialize;

use super::against::{Comparison, PeerBenchmark};
use super::layers::{self, LayerTime, RUNS};
use super::networks::Network;
use super::noise::Noise;
use super::start::StartTime;
use super::{BenchInferArgs, Peak};
use crate::all::{Figure, threads};
use evpose_cli::latency::{self, Runner};
use evpose_cli::progress::say;
use evpose_core::stats::quantile::nearest_rank;

/// Results of a measurement.
#[derive(Debug, Serialize)]
pub(super) struct Case {
    network: String,
    width: f32,
    parameters: usize,
    /// Batch size, channels, rows and columns.
    input: [usize; 4],
    /// The runtime: our engine or Burn.
    by: &'static str,
    precision: Precision,
    /// Instruction set of the engine, with AMX if it is used.
    level: Option<String>,
    threads: usize,
    runs: usize,
    p50_ms: f64,
    p95_ms: f64,
    p99_ms: f64,
    mean_ms: f64,
    min_ms: f64,
    windows_per_second: f64,
    /// MACs of the network as defined over the median time: algorithms with fewer MACs may exceed
    /// the peak.
    gflop_per_s: Option<f64>,
    /// The same relative to the peak of the processor.
    of_peak: Option<f64>,
    noise: Noise,
    /// Start-up time in f32.
    start: Option<StartTime>,
    layers: Vec<LayerTime>,
    against: Vec<Comparison>,
}

pub(crate) struct MeasuredLayers {
    pub(crate) network: String,
    pub(crate) threads: usize,
    pub(crate) layers: Vec<LayerTime>,
}

/// Settings shared by the cases of a network.
pub(super) struct Setting<'a> {
    pub(super) args: &'a BenchInferArgs,
    pub(super) network: &'a Network,
    pub(super) seed: u64,
}

impl Setting<'_> {
    /// Measures Burn's network.
    pub(super) fn burn(&self, threads: usize, device: &Device) -> Case {
        let Self { args, network, seed } = self;
        let mut case = self.timed(&mut network.burn(device), Precision::F32, threads);
        case.say();
        if args.layers {
            case.layers = layers::of_burn(network, args.batch, *seed, args.runs.min(RUNS), device);
            layers::table(&case.layers).iter().for_each(say);
        }
        case
    }

    /// Measures our engine, and compares it with other runtimes.
    ///
    /// # Errors
    /// If another runtime is not available, or its outputs differ.
    pub(super) fn engine(&self, engine: Engine, precision: Precision, peak: &Peak) -> Result<Case> {
        let macs: u64 = engine.layers().iter().map(|layer| layer.macs).sum();
        let instructions = engine.instructions();
        let mut runner = Runner::Engine(Box::new(engine));
        let mut case = self.timed(&mut runner, precision, peak.threads);
        // Two operations for a multiply-accumulate.
        let gflop = 2e-9 * macs as f64 * self.args.batch as f64;
        let gflop_per_s = gflop / (case.p50_ms * 1e-3);
        case.gflop_per_s = Some(gflop_per_s);
        case.of_peak = Some(gflop_per_s / peak.gflop_per_s);
        case.level = Some(instructions);
        case.say();
        if precision == Precision::F32 {
            let level = self.args.level.unwrap_or_else(Level::best);
            let options = EngineOptions::default().with_threads(peak.threads).with_level(level);
            let start = self.network.start(options)?;
            start.say();
            case.start = Some(start);
        }
        let Runner::Engine(engine) = &mut runner else { return Ok(case) };
        if self.args.layers {
            case.layers = layers::timed(engine, self.network.input, self.seed, peak.gflop_per_s);
            layers::table(&case.layers).iter().for_each(say);
        }
        let benchmark = PeerBenchmark {
            graph: &self.network.graph,
            shape: self.network.input,
            image: &self.network.image(self.seed),
            precision,
            pairs: self.args.pairs as usize,
        };
        case.against = benchmark.run(engine, &self.args.against)?;
        Ok(case)
    }

    fn timed(&self, runner: &mut Runner<'_>, precision: Precision, threads: usize) -> Case {
        let [channels, height, width] = self.network.input;
        let input = [self.args.batch, channels, height, width];
        let times_ms = latency::times_ms(runner, input, self.args.runs.max(1), self.seed);
        // A copy is sorted: the drift is seen in the order of the runs alone.
        let mut sorted_ms = times_ms.clone();
        sorted_ms.sort_by(f64::total_cmp);
        let mean_ms = times_ms.iter().sum::<f64>() / times_ms.len() as f64;
        Case {
            network: self.network.name.clone(),
            width: self.network.width,
            parameters: self.network.parameters,
            input,
            by: if matches!(runner, Runner::Engine(_)) { "the engine" } else { "Burn" },
            precision,
            level: None,
            threads,
            runs: times_ms.len(),
            p50_ms: nearest_rank(&sorted_ms, 0.50),
            p95_ms: nearest_rank(&sorted_ms, 0.95),
            p99_ms: nearest_rank(&sorted_ms, 0.99),
            mean_ms,
            min_ms: sorted_ms[0],
            // Throughput includes the slow runs, hence the mean and not the median.
            windows_per_second: self.args.batch as f64 * 1e3 / mean_ms,
            gflop_per_s: None,
            of_peak: None,
            noise: Noise::from_times(&times_ms),
            start: None,
            layers: Vec::new(),
            against: Vec::new(),
        }
    }
}

impl Case {
    /// The median time beside peers, whose ratios are those of interleaved pairs. Its limit is the arithmetic of
    /// the network as defined, at the peak: algorithms with fewer multiplications may be faster.
    pub(super) fn figure(&self) -> Figure {
        let work = format!("{}, {}, {}", self.network, self.precision, threads(self.threads));
        let mut figure = Figure::time("infer", work, "ms", self.p50_ms);
        figure.limit = self.of_peak.map(|of_peak| self.p50_ms * of_peak);
        figure.peers = self.against.iter().map(Comparison::figure).collect();
        figure
    }

    pub(super) fn has_layers(&self) -> bool {
        !self.layers.is_empty()
    }

    pub(super) fn take_layers(&mut self) -> MeasuredLayers {
        MeasuredLayers {
            network: self.network.clone(),
            threads: self.threads,
            layers: std::mem::take(&mut self.layers),
        }
    }

    /// Prints the results.
    fn say(&self) {
        let [batch, channels, height, width] = self.input;
        let level = self.level.as_deref().map_or_else(String::new, |level| format!(" by {level}"));
        say(format!(
            "network   {} of width {}, {} parameters, input {batch}x{channels}x{height}x{width}, \
             {}, {}{level}, {} threads",
            self.network, self.width, self.parameters, self.by, self.precision, self.threads
        ));
        say(format!(
            "latency   p50 {:.2} ms  p95 {:.2} ms  p99 {:.2} ms  ({} runs, mean {:.2}, min {:.2})",
            self.p50_ms, self.p95_ms, self.p99_ms, self.runs, self.mean_ms, self.min_ms
        ));
        let gflop = match (self.gflop_per_s, self.of_peak) {
            (Some(gflop_per_s), Some(of_peak)) => {
                format!("  {gflop_per_s:.1} GFLOP/s, {:.0} % of the peak", 100.0 * of_peak)
            }
            _ => String::new(),
        };
        say(format!("rate      {:.1} windows/s{gflop}", self.windows_per_second));
        if let Some(warning) = self.noise.warning() {
            say(format!("warning   {warning}: the machine was under load, measure again"));
        }
    }
}
