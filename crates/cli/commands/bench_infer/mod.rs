//! `evpose bench infer`: how long one prediction takes.

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
use evpose_infer::{EngineOptions, Level};
use evpose_kernels::blocked::{Team, peak_gflop_per_s};
use serde::Serialize;

use crate::args::BenchInferArgs;
use crate::commands::{as_json, config_source, use_threads};
use crate::machine::Machine;
use crate::progress::say;
use crate::run_info::COMMIT;
use case::{Case, Setting};

/// What a benchmark measured and where.
#[derive(Debug, Serialize)]
struct Report {
    machine: Machine,
    commit: &'static str,
    device: String,
    seed: u64,
    peaks: Vec<Peak>,
    cases: Vec<Case>,
}

/// What the processor can do at best.
#[derive(Debug, Serialize)]
struct Peak {
    level: String,
    threads: usize,
    /// Of 32 bits, in registers only.
    gflop_per_s: f64,
}

pub(crate) fn run(args: &BenchInferArgs) -> Result<()> {
    let config = config_source::load(&args.config, &[])?;
    let device = args.device.resolve()?;
    let is_engine = !args.burn && device == Device::flex();
    ensure!(
        is_engine || args.threads.len() <= 1 && args.against.is_empty(),
        "several numbers of threads and --against are for our engine, on the device flex"
    );
    ensure!(
        args.against.is_empty() || args.batch == 1,
        "other runtimes are given one window at a time: leave --batch out"
    );
    if !is_engine {
        use_threads(args.threads.first().copied())?;
    }
    let machine = Machine::this();
    let threads =
        if args.threads.is_empty() { vec![machine.threads] } else { args.threads.clone() };
    let level = args.level.unwrap_or_else(Level::best);
    say(format!("machine   {machine}"));
    let mut report = Report {
        machine,
        commit: COMMIT,
        device: args.device.name().to_owned(),
        seed: config.seed,
        peaks: Vec::new(),
        cases: Vec::new(),
    };
    if is_engine {
        report.peaks = threads.iter().map(|threads| Peak::of(*threads, level)).collect();
    }
    for name in networks::names(&config, &args.network)? {
        let network = networks::network(&config, &name, &device)?;
        let setting = Setting { args, network: &network, seed: config.seed };
        if !is_engine {
            report.cases.push(setting.burn(network.burn(&device), threads[0]));
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
    as_json(args.json.as_deref(), &report)
}

impl Peak {
    /// Measures it.
    fn of(threads: usize, level: Level) -> Self {
        let gflop_per_s = peak_gflop_per_s(&Team::new(threads), level);
        say(format!("peak      {gflop_per_s:.1} GFLOP/s in f32 by {level}, {threads} threads"));
        Self { level: level.to_string(), threads, gflop_per_s }
    }
}
