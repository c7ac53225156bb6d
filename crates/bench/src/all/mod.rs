//! `evpose bench all`: every speed beside peers and the limits of the machine, as a page.

mod figure;
mod limits;
mod page;
mod stored;

use std::path::PathBuf;

use anyhow::Result;
use clap::ValueEnum as _;
use evpose_cli::args::DeviceArgs;
use evpose_cli::json::write_json;
use evpose_cli::progress::say;
use evpose_cli::provenance::Provenance;
use evpose_infer::Precision;
use evpose_nn::{DeviceKind, MOVE_ENET};
use evpose_task::schedule::TrainingPrecision;

pub(crate) use figure::{Figure, PeerFigure, threads};

use crate::infer::peers::PeerName;
use crate::infer::{BenchInferArgs, MeasuredLayers};
use crate::io::BenchIoArgs;
use crate::repr::BenchReprArgs;
use crate::sensor::BenchSensorArgs;
use crate::sim::BenchSimArgs;
use crate::train::BenchTrainArgs;
use evpose_cli::outputs::{OutputFile, write_file};
use limits::MachineLimits;
use stored::StoredRun;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose bench all --html bench.html\n  \
    evpose bench all --json now.json --before benches/machines/epyc.json\n  \
    ORT_DYLIB_PATH=libonnxruntime.so evpose bench all --html bench.html\n\n\
    Takes a minute on two idle cores. Other runtimes are timed where a program built with --features peers finds their \
    libraries, as `evpose bench infer` does.")]
pub struct BenchAllArgs {
    /// Where to write the page, one file with charts inside
    #[arg(long, value_name = "FILE", default_value = "bench.html")]
    pub(crate) html: OutputFile,
    /// Where to write the figures as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<OutputFile>,
    /// Figures of an earlier run, written with --json: changes of more than 10 % are listed
    #[arg(long, value_name = "FILE")]
    pub(crate) before: Option<PathBuf>,
    /// Shorter measurements: noisier figures in half a minute
    #[arg(long)]
    pub(crate) quick: bool,
    /// These benchmarks alone
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub(crate) only: Vec<Section>,
}

/// The benchmarks of the page, in its order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Section {
    /// Networks in f32 and int8, beside other runtimes
    Infer,
    /// Training steps of both networks
    Train,
    /// The simulated sensor
    Sensor,
    /// The simulation of labelled hands
    Sim,
    /// Representations of events
    Repr,
    /// Files of events
    Io,
}

/// How long each benchmark measures.
struct Effort {
    infer_runs: usize,
    infer_pairs: u32,
    train_steps: usize,
    seconds: f64,
    passes: usize,
    events: usize,
}

impl Effort {
    const WHOLE: Self = Self {
        infer_runs: 100,
        infer_pairs: 20,
        train_steps: 15,
        seconds: 3.0,
        passes: 9,
        events: 1_000_000,
    };
    const QUICK: Self = Self {
        infer_runs: 10,
        infer_pairs: 20,
        train_steps: 2,
        seconds: 0.2,
        passes: 2,
        events: 100_000,
    };
}

pub(crate) fn run(args: &BenchAllArgs) -> Result<()> {
    // Read first, so that a wrong path does not cost the whole run.
    let before = args.before.as_deref().map(StoredRun::read).transpose()?;
    let effort = if args.quick { Effort::QUICK } else { Effort::WHOLE };
    let provenance = Provenance::this();
    let mut counts = vec![1, provenance.machine.threads];
    // A machine of one thread is measured once.
    counts.dedup();
    let limits: Vec<_> = counts.iter().map(|threads| MachineLimits::measure(*threads)).collect();

    let (mut figures, mut layers) = (Vec::new(), Vec::new());
    for section in Section::value_variants() {
        if !args.only.is_empty() && !args.only.contains(section) {
            continue;
        }
        heading(section.heading());
        match section {
            Section::Infer => {
                let (of_networks, of_layers) = inference(&effort, &counts)?;
                figures.extend(of_networks);
                layers = of_layers;
            }
            Section::Train => {
                for network in [None, Some(MOVE_ENET)] {
                    figures.push(crate::train::figure(&training(&effort, network))?);
                }
            }
            Section::Sensor => {
                let seconds = effort.seconds;
                let args = BenchSensorArgs { seconds, threads: None, peer: Vec::new(), json: None };
                figures.extend(crate::sensor::figures(&args)?);
            }
            Section::Sim => figures.extend(crate::sim::figures(&simulation(args.quick))?),
            Section::Repr => figures.extend(crate::repr::figures(&representations(&effort))?),
            Section::Io => figures.extend(crate::io::figures(&files(&effort))?),
        }
    }

    let run = StoredRun { provenance, limits, figures };
    // Before the page: an error of drawing does not cost the figures.
    write_json(args.json.as_deref(), &run)?;
    let page = page::html(&run, &layers, before.as_ref())?;
    write_file(&args.html, page)?;
    say(format!("page      {}", args.html.display()));
    if let Some(before) = &before {
        stored::changes(&run, before).iter().for_each(say);
    }
    Ok(())
}

impl Section {
    fn heading(self) -> &'static str {
        match self {
            Self::Infer => "inference",
            Self::Train => "training",
            Self::Sensor => "sensor",
            Self::Sim => "simulation",
            Self::Repr => "representations",
            Self::Io => "files",
        }
    }
}

fn heading(text: &str) {
    say(format!("\n== {text}"));
}

/// Both networks in f32 beside peers that are found, with their layers, and quantised.
fn inference(effort: &Effort, counts: &[usize]) -> Result<(Vec<Figure>, Vec<MeasuredLayers>)> {
    let peers = found_peers();
    if peers.is_empty() {
        say(
            "peers     none: a program built with --features peers times ONNX Runtime, OpenVINO and tract",
        );
    }
    let args = |precision, against: &[PeerName], layers| BenchInferArgs {
        config: "eventhands".to_owned(),
        network: vec!["resnet18".to_owned(), MOVE_ENET.to_owned()],
        precision: vec![precision],
        threads: counts.to_vec(),
        level: None,
        runs: effort.infer_runs,
        batch: 1,
        burn: false,
        layers,
        against: against.to_vec(),
        pairs: effort.infer_pairs,
        json: None,
        device: DeviceKind::Flex,
    };
    let (mut figures, layers) = crate::infer::figures(&args(Precision::F32, &peers, true))?;
    // Its default precision is what OpenVINO has to offer against 8 bits.
    let openvino = peers.contains(&PeerName::Openvino);
    let peers = if openvino { vec![PeerName::OpenvinoDefault] } else { Vec::new() };
    figures.extend(crate::infer::figures(&args(Precision::Int8, &peers, false))?.0);
    Ok((figures, layers))
}

/// Runtimes whose libraries the environment names, and the one that is built in.
fn found_peers() -> Vec<PeerName> {
    if !cfg!(feature = "peers") {
        return Vec::new();
    }
    let is_set = |name: &str| std::env::var_os(name).is_some();
    let known = [
        (PeerName::Onnxruntime, is_set("ORT_DYLIB_PATH")),
        (PeerName::Openvino, is_set("OPENVINO_DYLIB_PATH")),
        (PeerName::Tract, true),
    ];
    known.into_iter().filter(|(_, is_found)| *is_found).map(|(name, _)| name).collect()
}

fn training(effort: &Effort, network: Option<&str>) -> BenchTrainArgs {
    BenchTrainArgs {
        config: "eventhands".to_owned(),
        network: network.map(str::to_owned),
        steps: effort.train_steps,
        batch: 16,
        burn: false,
        precision: TrainingPrecision::F32,
        json: None,
        device: DeviceArgs { device: DeviceKind::Flex, threads: None },
    }
}

fn simulation(quick: bool) -> BenchSimArgs {
    BenchSimArgs {
        config: "eventhands".to_owned(),
        sequences: 4,
        seconds: 10.0,
        quick,
        threads: None,
        scratch: None,
        json: None,
    }
}

fn representations(effort: &Effort) -> BenchReprArgs {
    BenchReprArgs {
        events: effort.events,
        passes: effort.passes,
        only: vec!["240x180".to_owned()],
        image: None,
        peers: Vec::new(),
        json: None,
    }
}

fn files(effort: &Effort) -> BenchIoArgs {
    BenchIoArgs {
        frames: (effort.events / 20) as u64,
        events_per_frame: 200,
        passes: effort.passes,
        events: effort.events,
        only: Vec::new(),
        files: Vec::new(),
        peers: Vec::new(),
        scratch: None,
        json: None,
    }
}
