//! What can be measured.

use std::path::PathBuf;

use clap::Subcommand;
use evpose_infer::{Level, Precision};
use evpose_nn::DeviceKind;

use super::{DeviceArgs, parse_threads};
use crate::commands::bench_infer::peers::PeerName;
use crate::commands::bench_live::BenchLiveArgs;
use crate::contest::PeerCommand;

/// What can be measured.
#[derive(Debug, Subcommand)]
pub(crate) enum BenchCommand {
    /// Latency of networks on one window at a time, layer by layer, beside other runtimes
    Infer(BenchInferArgs),
    /// Time and memory of a training step of a network
    Train(BenchTrainArgs),
    /// Cost of the event camera per pixel and step, on one core
    Sensor(BenchSensorArgs),
    /// Steps a second of the labelled hand simulation, and where the time goes
    Sim(BenchSimArgs),
    /// Events and labels a second from files in the page cache, on one core
    Io(BenchIoArgs),
    /// How fast representations take events in and are drawn
    Repr(BenchReprArgs),
    /// How much of a busy camera comes through as poses, and how late
    Live(BenchLiveArgs),
}

#[derive(Debug, clap::Args)]
#[command(after_help = format!("Examples:\n  evpose bench io\n  evpose bench io --only aedat4 --json io.json\n  \
    evpose bench io --file rec.raw --peer 'dv=python3 peer.py'\n\n{PEERS}\n\
    Build with --features peers to time other decoders of EVT 3.0 in the same run."))]
pub(crate) struct BenchIoArgs {
    /// Frames of 1 ms in the file that is made for it
    #[arg(long, default_value_t = 250_000)]
    pub(crate) frames: u64,
    /// Events in each, on average
    #[arg(long, default_value_t = 200)]
    pub(crate) events_per_frame: u32,
    /// Times each reader reads it all
    #[arg(long, default_value_t = 15)]
    pub(crate) passes: usize,
    /// Events in each file of the other formats
    #[arg(long, default_value_t = 2_000_000)]
    pub(crate) events: usize,
    /// Only cases with this in their name; given twice, with both
    #[arg(long, value_name = "WORD")]
    pub(crate) only: Vec<String>,
    /// A recording of yours to read as well (may be repeated)
    #[arg(long = "file", value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Another program on the same files, in the same run (may be repeated)
    #[arg(long = "peer", value_name = "NAME=COMMAND")]
    pub(crate) peers: Vec<PeerCommand>,
    /// Folder for the files [default: the system's for temporary files]
    #[arg(long)]
    pub(crate) scratch: Option<PathBuf>,
    /// Where to write the numbers
    #[arg(long)]
    pub(crate) json: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
#[command(after_help = format!("Examples:\n  evpose bench repr\n  \
    evpose bench repr --only eros --only 640x480 --json repr.json\n  \
    evpose bench repr --peer 'tonic=python3 peer.py'\n\n{PEERS}"))]
pub(crate) struct BenchReprArgs {
    /// Events in 100 ms
    #[arg(long, default_value_t = 1_000_000)]
    pub(crate) events: usize,
    /// Times each case runs; the median counts
    #[arg(long, default_value_t = 31)]
    pub(crate) passes: usize,
    /// Only cases with this in their name; given twice, with both
    #[arg(long, value_name = "WORD")]
    pub(crate) only: Vec<String>,
    /// Image for blur and Canny, of the size it has [default: discs, shades and grain, 1000x1000]
    #[arg(long, value_name = "FILE")]
    pub(crate) image: Option<PathBuf>,
    /// Another program on the same events, in the same run (may be repeated)
    #[arg(long = "peer", value_name = "NAME=COMMAND")]
    pub(crate) peers: Vec<PeerCommand>,
    /// Where to write the numbers
    #[arg(long)]
    pub(crate) json: Option<PathBuf>,
}

/// What a program has to do to be measured beside ours.
const PEERS: &str = "A peer is a shell command. It finds the files of the benchmark in the folder \
    $EVPOSE_BENCH and prints\n`CASE: FIGURE` for the cases it knows, in the unit that is printed for \
    them.";

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose bench sim\n  evpose bench sim --quick\n  \
    evpose bench sim --sequences 2 --seconds 5 --json sim.json\n\n\
    Build with --features peers to time other rasterisers in the same run.")]
pub(crate) struct BenchSimArgs {
    /// A TOML file, or an embedded config: its simulation is measured
    #[arg(long, default_value = "eventhands")]
    pub(crate) config: String,
    /// Sequences of each mesh
    #[arg(long, default_value_t = 10)]
    pub(crate) sequences: u64,
    /// Simulated seconds of each sequence
    #[arg(long, default_value_t = 50.0)]
    pub(crate) seconds: f64,
    /// A short look: 4 sequences of 2 s, in which beginnings weigh more
    #[arg(long, conflicts_with_all = ["sequences", "seconds"])]
    pub(crate) quick: bool,
    /// Sequences at a time; one on each core by default
    #[arg(long)]
    pub(crate) threads: Option<usize>,
    /// Folder for the files, removed after each sequence [default: the system's for temporary files]
    #[arg(long)]
    pub(crate) scratch: Option<PathBuf>,
    /// Where to write the numbers
    #[arg(long)]
    pub(crate) json: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose bench infer\n  \
    evpose bench infer --threads 1 --layers\n  \
    evpose bench infer --network all --threads 1,2 --json bench.json\n  \
    evpose bench infer --config quick --burn\n  \
    ORT_DYLIB_PATH=libonnxruntime.so evpose bench infer --threads 1,2 --against onnxruntime,tract\n\n\
    Other runtimes need a program built with --features peers; docs/guide/bench-infer.md says where \
    to get their\nlibraries and what the figures mean.")]
pub(crate) struct BenchInferArgs {
    /// A TOML file, or an embedded config: its network and image size are measured
    #[arg(long, default_value = "eventhands")]
    pub(crate) config: String,
    /// Networks of the registry instead of the config's own, of the config's width, or `all`
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub(crate) network: Vec<String>,
    /// Bits that are computed in: f32, bf16 or int8
    #[arg(long, value_delimiter = ',', default_value = "f32")]
    pub(crate) precision: Vec<Precision>,
    /// CPU threads, one figure for each number; all cores by default
    #[arg(long, value_delimiter = ',', value_parser = parse_threads)]
    pub(crate) threads: Vec<usize>,
    /// Instructions of the engine: avx512, avx2 or portable [default: the best there are]
    #[arg(long, value_parser = parse_level)]
    pub(crate) level: Option<Level>,
    /// Measured runs, after a tenth as many to warm up
    #[arg(long, default_value_t = 100)]
    pub(crate) runs: usize,
    /// Windows per run
    #[arg(long, default_value_t = 1)]
    pub(crate) batch: usize,
    /// Time Burn's arithmetic instead of our engine
    #[arg(long)]
    pub(crate) burn: bool,
    /// Show where the time goes, layer by layer
    #[arg(long, conflicts_with = "burn")]
    pub(crate) layers: bool,
    /// Compare with other runtimes on the same network, by turns in the same run
    #[arg(long, value_name = "PEER", value_delimiter = ',', conflicts_with = "burn")]
    pub(crate) against: Vec<PeerName>,
    /// Pairs of bursts for each other runtime
    #[arg(long, default_value_t = 30, value_parser = clap::value_parser!(u32).range(20..))]
    pub(crate) pairs: u32,
    /// Where to write the numbers
    #[arg(long)]
    pub(crate) json: Option<PathBuf>,
    /// flex (CPU), ndarray, wgpu or cuda; all but flex need the Cargo feature of that name
    #[arg(long, default_value = "flex")]
    pub(crate) device: DeviceKind,
}

/// Instructions by their name, if this processor has them.
fn parse_level(text: &str) -> Result<Level, String> {
    let levels = Level::available();
    let found = levels.iter().copied().find(|level| level.to_string() == text);
    found.ok_or_else(|| {
        let names: Vec<String> = levels.iter().map(Level::to_string).collect();
        format!("this processor has {}", names.join(", "))
    })
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose bench train\n  \
    evpose bench train --threads 1 --burn\n  \
    evpose bench train --config quick --steps 50 --json train.json\n\n\
    Windows and poses are random. A step is the forward pass with the loss, the backward pass and Adam.")]
pub(crate) struct BenchTrainArgs {
    /// A TOML file, or an embedded config: its network and image size are measured
    #[arg(long, default_value = "eventhands")]
    pub(crate) config: String,
    /// A network of the registry instead of the config's own, of the config's width
    #[arg(long, value_name = "NAME")]
    pub(crate) network: Option<String>,
    /// Measured steps, after two to warm up
    #[arg(long, default_value_t = 20)]
    pub(crate) steps: usize,
    /// Windows of a step
    #[arg(long, default_value_t = 16)]
    pub(crate) batch: usize,
    /// Time Burn's arithmetic instead of our kernels
    #[arg(long)]
    pub(crate) burn: bool,
    /// Where to write the numbers
    #[arg(long)]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

#[derive(Debug, clap::Args)]
#[command(
    after_help = "A peer is a program that is started once for each setting. In its words, which \
    spaces divide,\n  {frames}   is an .npy file of u1 (frames, height, width), to be shown over and \
    over,\n  {fps}      the frames per second,\n  {setting}  `thresholds` (thresholds that differ \
    from pixel to pixel) or `all`\n             (and low-pass, leak, shot noise and a refractory \
    period),\n  {seconds}  for how long to measure.\n\
    It prints its nanoseconds per pixel and step, on one core, as its last line.\n\n\
    Examples:\n  evpose bench sensor\n  \
    evpose bench sensor --json sensor.json --peer \"other=./other {frames} {fps} {setting}\""
)]
pub(crate) struct BenchSensorArgs {
    /// Seconds for each setting and peer
    #[arg(long, default_value_t = 3.0)]
    pub(crate) seconds: f64,
    /// Another simulator to be timed on the same frames (may be repeated)
    #[arg(long, value_name = "NAME=COMMAND")]
    pub(crate) peer: Vec<String>,
    /// Where to write the numbers
    #[arg(long)]
    pub(crate) json: Option<PathBuf>,
}
