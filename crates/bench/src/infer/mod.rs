//! `evpose bench infer`: latency of an inference.

mod against;
mod case;
mod layers;
mod networks;
mod noise;
pub(crate) mod peers;
mod precision;
mod start;

use anyhow::{Result, ensure};
use burn::tensor::Device;
use evpose_infer::{EngineOptions, Level, Precision};
use evpose_kernels::blocked::{ThreadPool, peak_gflop_per_s};
use serde::Serialize;

use crate::all::Figure;
pub(crate) use case::MeasuredLayers;
use case::{Case, Setting};
use evpose_cli::configs;
use evpose_cli::json::write_json;
use evpose_cli::outputs::OutputFile;
use evpose_cli::progress::say;
use evpose_cli::provenance::Provenance;
use evpose_cli::ranges::{count, threads, within};
use evpose_cli::threads::use_threads;
use evpose_nn::{DeviceKind, adapter_name};
use evpose_task::hand::HandConfig;
use peers::PeerName;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose bench infer\n  \
    evpose bench infer --threads 1 --layers\n  \
    evpose bench infer --network all --threads 1,2 --json bench.json\n  \
    evpose bench infer --config quick --burn\n  \
    ORT_DYLIB_PATH=libonnxruntime.so evpose bench infer --threads 1,2 --against onnxruntime,tract\n\n\
    Other runtimes need a program built with --features peers; docs/guide/bench-infer.md describes \
    where to get their libraries and how to read the results.")]
pub struct BenchInferArgs {
    /// A TOML file, or an embedded config: its network and image size are measured
    #[arg(long, default_value = "eventhands")]
    pub(crate) config: String,
    /// Networks of the registry instead of the config's own, at the config's width, or `all`
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub(crate) network: Vec<String>,
    /// Precisions: f32, bf16 or int8
    #[arg(long, value_delimiter = ',', default_value = "f32")]
    pub(crate) precision: Vec<Precision>,
    /// Counts of CPU threads, one measurement each; all cores by default
    #[arg(long, value_delimiter = ',', value_parser = threads())]
    pub(crate) threads: Vec<usize>,
    /// Instruction set of the engine: avx512, avx2 or portable [default: the best available]
    #[arg(long, value_parser = parse_level)]
    pub(crate) level: Option<Level>,
    /// Timed runs, after a tenth as many warm-up runs
    #[arg(long, default_value_t = 100, value_parser = count::<usize>())]
    pub(crate) runs: usize,
    /// Windows per run
    #[arg(long, default_value_t = 1, value_parser = within(1..=65_536_usize))]
    pub(crate) batch: usize,
    /// Time Burn instead of our engine
    #[arg(long)]
    pub(crate) burn: bool,
    /// Show the time per layer; of Burn's network each layer is waited for, and eight of its calls are timed
    #[arg(long)]
    pub(crate) layers: bool,
    /// Compare with other runtimes on the same network, interleaved in the same run
    #[arg(long, value_name = "PEER", value_delimiter = ',', conflicts_with = "burn")]
    pub(crate) against: Vec<PeerName>,
    /// Pairs of bursts for each other runtime
    #[arg(long, default_value_t = 30, value_parser = within(20..=1_000_000_u32))]
    pub(crate) pairs: u32,
    /// Where to write the results as JSON
    #[arg(long)]
    pub(crate) json: Option<OutputFile>,
    /// flex (CPU), ndarray, wgpu or cuda, of several GPUs wgpu:1; all but flex need the Cargo feature of
    /// that name, and `evpose info --devices` lists what there is
    #[arg(long, default_value = "flex")]
    pub(crate) device: DeviceKind,
}

/// Results, as written to JSON.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    provenance: Provenance,
    device: String,
    /// The hardware of the device, if it is a GPU.
    adapter: Option<String>,
    seed: u64,
    peaks: Vec<Peak>,
    cases: Vec<Case>,
}

/// Peak throughput of the processor.
#[derive(Debug, Serialize)]
struct Peak {
    level: String,
    threads: usize,
    /// In f32, on registers only.
    gflop_per_s: f64,
}

pub(crate) fn run(args: &BenchInferArgs) -> Result<()> {
    write_json(args.json.as_deref(), &measure(args)?)
}

/// Figures of the cases, and the layers of those that were measured layer by layer, by network and threads.
pub(crate) fn figures(args: &BenchInferArgs) -> Result<(Vec<Figure>, Vec<MeasuredLayers>)> {
    let mut report = measure(args)?;
    let figures = report.cases.iter().map(Case::figure).collect();
    let layers = report.cases.iter_mut().filter(|case| case.has_layers()).map(Case::take_layers);
    Ok((figures, layers.collect()))
}

fn measure(args: &BenchInferArgs) -> Result<Report> {
    let config: HandConfig = configs::load(&args.config, &[])?;
    let device = args.device.resolve()?;
    let is_engine = !args.burn && device == Device::flex();
    // What does not apply is refused: figures would look as if it had been applied.
    ensure!(
        is_engine
            || args.threads.len() <= 1
                && args.against.is_empty()
                && args.precision == [Precision::F32]
                && args.level.is_none(),
        "several thread counts, --precision, --level and --against are for our engine, on --device flex \
         without --burn"
    );
    ensure!(
        args.against.is_empty() || args.batch == 1,
        "other runtimes run at batch size 1: leave --batch out"
    );
    // The engine has threads of its own.
    if !is_engine {
        use_threads(args.threads.first().copied())?;
    }
    let provenance = Provenance::this();
    let threads = if args.threads.is_empty() {
        vec![provenance.machine.threads]
    } else {
        args.threads.clone()
    };
    let level = args.level.unwrap_or_else(Level::best);
    say(format!("machine   {}", provenance.machine));
    let mut report = Report {
        provenance,
        device: args.device.to_string(),
        adapter: adapter_name(&device),
        seed: config.seed,
        peaks: Vec::new(),
        cases: Vec::new(),
    };
    if let Some(adapter) = &report.adapter {
        say(format!("device    {}: {adapter}", report.device));
    }
    // At the level and thread count that are measured: figures are relative to them.
    if is_engine {
        report.peaks = threads.iter().map(|threads| Peak::measure(*threads, level)).collect();
    }
    for name in networks::names(&config, &args.network)? {
        let network = networks::network(&config, &name, &device)?;
        let setting = Setting { args, network: &network, seed: config.seed };
        if !is_engine {
            report.cases.push(setting.burn(threads[0], &device));
            continue;
        }
        for precision in &args.precision {
            for peak in &report.peaks {
                let options = EngineOptions::default().with_threads(peak.threads).with_level(level);
                let options = options.with_precision(*precision);
                let engine = precision::compiled(&network, options, config.seed)?;
                report.cases.push(setting.engine(engine, *precision, peak)?);
            }
        }
    }
    Ok(report)
}

impl Peak {
    fn measure(threads: usize, level: Level) -> Self {
        let gflop_per_s = peak_gflop_per_s(&ThreadPool::new(threads), level);
        say(format!("peak      {gflop_per_s:.1} GFLOP/s in f32 by {level}, {threads} threads"));
        Self { level: level.to_string(), threads, gflop_per_s }
    }
}

/// Instruction sets by name, if this processor has them.
fn parse_level(text: &str) -> Result<Level, String> {
    let levels = Level::available();
    let level = levels.iter().copied().find(|level| level.to_string() == text);
    level.ok_or_else(|| {
        let names: Vec<String> = levels.iter().map(Level::to_string).collect();
        format!("this processor has {}", names.join(", "))
    })
}
