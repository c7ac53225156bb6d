//! Arguments of `evpose bench live`.

use std::path::PathBuf;

use evpose_cli::args::DeviceArgs;
use evpose_cli::outputs::OutputFile;
use evpose_cli::ranges::{seconds, within};

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    evpose bench live --checkpoint body\n  \
    evpose bench live --task hand --speeds 1,10 --seconds 20 --json live.json\n  \
    evpose bench live --source rec.raw --checkpoint runs/body/finetune --speeds 1\n  \
    evpose bench live --soak 1e9\n\n\
    Without --source, a person before a hand-held camera is simulated, and events are removed or noise is \
    added to reach the event rate of --rate. Without --checkpoint, the network has the published size and \
    random weights. Latency counts from the host time of the newest event of a pose.")]
pub struct BenchLiveArgs {
    /// Task, `hand` or `body`, without --checkpoint
    #[arg(long, default_value = "body")]
    pub(crate) task: String,
    /// A run directory, a .bpk file, or the name of a shipped network [default: the published network, not
    /// trained]
    #[arg(long)]
    pub(crate) checkpoint: Option<PathBuf>,
    /// A recording [default: a simulated one]
    #[arg(long)]
    pub(crate) source: Option<PathBuf>,
    /// Event rate of the simulated recording, per second
    #[arg(long, default_value_t = 5e6, value_parser = within(1.0..=1e10))]
    pub(crate) rate: f64,
    /// Playback speeds, one row each
    #[arg(long, value_delimiter = ',', default_values_t = [1.0, 2.0, 5.0, 10.0], value_parser = within(1e-3..=1e6))]
    pub(crate) speeds: Vec<f64>,
    /// Length of a measurement in seconds
    #[arg(long, default_value_t = 10.0, value_parser = seconds())]
    pub(crate) seconds: f64,
    /// Event rates of measurements of the input alone, in millions per second, one row each
    #[arg(long, value_delimiter = ',', value_name = "MILLIONS", default_values_t = [10.0, 20.0, 40.0, 80.0], value_parser = within(1e-6..=1e6))]
    pub(crate) input: Vec<f64>,
    /// Instead, play so many events as fast as possible and measure the memory
    #[arg(long, value_name = "EVENTS", value_parser = within(1.0..=1e15))]
    pub(crate) soak: Option<f64>,
    /// Where to write the results as JSON
    #[arg(long)]
    pub(crate) json: Option<OutputFile>,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}
