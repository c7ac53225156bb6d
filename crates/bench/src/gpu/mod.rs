//! `evpose bench gpu`: everything to know about a GPU, in a few minutes and without a network.
//!
//! * [`plan`]: the steps, the worthiest first.
//! * [`step`]: one of them, in a process of its own that is ended when its time is over.
//! * [`agreement`]: outputs and gradients beside those of the CPU.

mod agreement;
mod plan;
mod step;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use clap::{FromArgMatches as _, Subcommand as _};
use evpose_cli::json::{write_json, write_result};
use evpose_cli::progress::{note, say};
use evpose_cli::provenance::Provenance;
use evpose_nn::{Adapter, Availability, DeviceKind};
use serde::Serialize;
use serde_json::{Map, Value};

use crate::BenchCommand;
use evpose_cli::outputs::OutputFile;
use evpose_cli::ranges::within;
use plan::{Plan, Step};
use step::Finished;

const RESULTS: &str = "gpu.json";
/// Folder of what the steps write.
const PARTS: &str = "parts";

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose bench gpu --minutes 9 --out gpu\n  \
    evpose bench gpu --small --device wgpu --out gpu\n  \
    evpose bench gpu --out gpu --resume runs/hand --data data/train\n\n\
    Every step runs in a process of its own, which is ended when its time is over; results are written after \
    each. What time is left trains on the fastest device.")]
pub struct BenchGpuArgs {
    /// Minutes for everything
    #[arg(long, default_value_t = 9.0, value_parser = within(0.1..=1e4))]
    minutes: f64,
    /// Folder of the results
    #[arg(long, default_value = "gpu")]
    out: PathBuf,
    /// Devices to measure [default: the GPUs of this build and machine]
    #[arg(long, value_delimiter = ',')]
    device: Vec<DeviceKind>,
    /// Small networks and few runs, to try it out
    #[arg(long)]
    small: bool,
    /// A run to continue training in the time that is left
    #[arg(long, value_name = "RUN", requires = "data")]
    resume: Option<PathBuf>,
    /// The training data of that run
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Only the steps whose names begin so
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    only: Vec<String>,
    /// Benchmarks to run in this process, as lines of arguments
    #[arg(long, hide = true)]
    series: Vec<String>,
    /// A device to compare with the CPU in this process
    #[arg(long, hide = true)]
    agreement: Option<DeviceKind>,
    /// File that the comparison is written to
    #[arg(long, hide = true)]
    json: Option<OutputFile>,
}

/// Content of the results.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    provenance: Provenance,
    devices: Vec<Device>,
    /// A row for each work, with the times of all ways.
    cases: Vec<Map<String, Value>>,
    steps: Vec<Finished>,
}

#[derive(Debug, Serialize)]
struct Device {
    device: String,
    adapters: Vec<String>,
    missing: Option<String>,
}

impl Device {
    fn of(kind: DeviceKind) -> Self {
        let device = kind.to_string();
        let missing = |missing: &str| Some(missing.to_owned());
        let (adapters, missing) = match Availability::of(kind) {
            Availability::Adapters(adapters) => (adapters, None),
            Availability::NotBuilt => (Vec::new(), missing("not in this build")),
            Availability::Missing { reason } => (Vec::new(), Some(reason)),
        };
        let text = |Adapter { name, details }: &Adapter| format!("{name} ({details})");
        Self { device, adapters: adapters.iter().map(text).collect(), missing }
    }

    fn is_gpu(&self) -> bool {
        !self.adapters.is_empty() && !["flex", "ndarray"].contains(&self.device.as_str())
    }
}

pub(crate) fn run(args: &BenchGpuArgs) -> Result<()> {
    if let Some(device) = args.agreement {
        return write_json(args.json.as_deref(), &agreement::measure(device)?);
    }
    if !args.series.is_empty() {
        return series(&args.series);
    }
    all(args)
}

/// Runs benchmarks one after the other; one that fails does not stop the next.
fn series(lines: &[String]) -> Result<()> {
    let mut failed = None;
    for line in lines {
        let command = BenchCommand::augment_subcommands(clap::Command::new("bench"));
        let words = std::iter::once("bench").chain(line.split_whitespace());
        let matches = command.try_get_matches_from(words)?;
        say(format!("bench {line}"));
        if let Err(error) = crate::run(&BenchCommand::from_arg_matches(&matches)?) {
            note(format!("{error:#}"));
            failed = Some(error);
        }
    }
    failed.map_or(Ok(()), Err)
}

fn all(args: &BenchGpuArgs) -> Result<()> {
    let started = Instant::now();
    let deadline = started + Duration::from_secs_f64(60.0 * args.minutes);
    let parts = args.out.join(PARTS);
    std::fs::create_dir_all(&parts).with_context(|| format!("creating {}", parts.display()))?;
    let devices: Vec<Device> = DeviceKind::ALL.into_iter().map(Device::of).collect();
    for Device { device, adapters, missing } in &devices {
        say(format!("{device:<8} {}", missing.clone().unwrap_or_else(|| adapters.join("; "))));
    }
    let chosen: Vec<String> = if args.device.is_empty() {
        // CUDA comes last of all kinds, and is the fastest where it is there.
        devices
            .iter()
            .rev()
            .filter(|device| device.is_gpu())
            .map(|device| device.device.clone())
            .collect()
    } else {
        args.device.iter().map(DeviceKind::to_string).collect()
    };
    let plan = Plan { devices: &chosen, small: args.small };
    let mut report =
        Report { provenance: Provenance::this(), devices, cases: Vec::new(), steps: Vec::new() };
    let path = args.out.join(RESULTS);
    // A run that dies in its first step still lists its devices.
    write_result(&path, &report)?;
    let is_wanted = |step: &Step| {
        args.only.is_empty() || args.only.iter().any(|name| step.name.starts_with(name.as_str()))
    };
    for step in plan.steps().into_iter().filter(is_wanted) {
        // When the time is over, a step ends at once and is still listed.
        let left = deadline.saturating_duration_since(Instant::now());
        report.steps.push(step.run(&parts, left)?);
        report.cases = plan::cases(&report.steps);
        write_result(&path, &report)?;
        show(report.steps.last(), started);
    }
    if let (Some(run), Some(data)) = (&args.resume, &args.data) {
        let left = deadline.saturating_duration_since(Instant::now());
        let (device, way) = plan::fastest(&report.steps);
        // Paths have to be absolute, since the step runs in the folder of its parts.
        let step = Step::training(&absolute(run)?, &absolute(data)?, &device, way);
        report.steps.push(step.run(&parts, left)?);
        write_result(&path, &report)?;
        show(report.steps.last(), started);
    }
    Ok(())
}

fn absolute(path: &Path) -> Result<PathBuf> {
    std::fs::canonicalize(path).with_context(|| format!("opening {}", path.display()))
}

fn show(step: Option<&Finished>, started: Instant) {
    if let Some(step) = step {
        say(format!("{:5.0} s  {step}", started.elapsed().as_secs_f64()));
    }
}
