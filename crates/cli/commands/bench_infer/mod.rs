//! `evpose bench infer`: how long one prediction takes.

mod layers;

use anyhow::Result;
use evpose_train::untrained;
use layers::LayerTime;
use serde::Serialize;

use crate::args::BenchInferArgs;
use crate::commands::latency::{self, Runner};
use crate::commands::{as_json, config_source, device};
use crate::machine::Machine;
use crate::progress::say;
use crate::run_info::COMMIT;
use crate::timing::{outliers, quantile};

/// What a benchmark measured and where.
#[derive(Debug, Serialize)]
struct Report {
    network: String,
    width: f32,
    parameters: usize,
    input: [usize; 4],
    device: String,
    machine: Machine,
    commit: &'static str,
    runs: usize,
    p50_ms: f64,
    p95_ms: f64,
    p99_ms: f64,
    mean_ms: f64,
    min_ms: f64,
    windows_per_second: f64,
    /// Modified z-scores above 3.5 (Iglewicz and Hoaglin 1993): signs of a busy machine.
    outliers: usize,
    /// What computed: our engine or Burn.
    by: &'static str,
    threads: usize,
    layers: Vec<LayerTime>,
}

pub(crate) fn run(args: &BenchInferArgs) -> Result<()> {
    let config = config_source::load(&args.config, &[])?;
    let target = device(&args.device)?;
    let network = untrained(&config, &target)?;
    let sensor = config.simulation.image_size();
    let input = [args.batch, 2, usize::from(sensor.height), usize::from(sensor.width)];
    let mut runner = if args.burn {
        Runner::Burn(&network, &target)
    } else {
        Runner::usual(&network, input, &target)?
    };
    let times_ms = latency::sorted_ms(&mut runner, input, args.runs.max(1), config.seed);
    let by = if matches!(runner, Runner::Engine(_)) { "the engine" } else { "Burn" };
    let layers = match &mut runner {
        Runner::Engine(engine) if args.layers => layers::timed(engine, input, config.seed),
        _ => Vec::new(),
    };

    let mean_ms = times_ms.iter().sum::<f64>() / times_ms.len() as f64;
    let report = Report {
        network: config.network.backbone.clone(),
        width: config.network.width,
        parameters: burn::module::Module::num_params(&network),
        input,
        device: args.device.device.name().to_owned(),
        machine: Machine::this(),
        commit: COMMIT,
        runs: times_ms.len(),
        p50_ms: quantile(&times_ms, 0.50),
        p95_ms: quantile(&times_ms, 0.95),
        p99_ms: quantile(&times_ms, 0.99),
        mean_ms,
        min_ms: times_ms[0],
        windows_per_second: args.batch as f64 * 1e3 / mean_ms,
        outliers: outliers(&times_ms),
        by,
        threads: rayon::current_num_threads(),
        layers,
    };
    say(format!("machine   {}", report.machine));
    say(format!(
        "network   {} of width {}, {} parameters, input {:?}, on {} by {by}, {} threads",
        report.network,
        report.width,
        report.parameters,
        report.input,
        report.device,
        report.threads
    ));
    say(format!(
        "latency   p50 {:.2} ms  p95 {:.2} ms  p99 {:.2} ms  ({} runs, mean {:.2}, min {:.2})",
        report.p50_ms, report.p95_ms, report.p99_ms, report.runs, report.mean_ms, report.min_ms
    ));
    say(format!("through   {:.1} windows/s", report.windows_per_second));
    layers::table(&report.layers).iter().for_each(say);
    if report.outliers * 10 > report.runs {
        say(format!(
            "warning   {} of {} runs were outliers: the machine was busy, measure again",
            report.outliers, report.runs
        ));
    }
    as_json(args.json.as_deref(), &report)
}
