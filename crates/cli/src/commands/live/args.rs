//! Arguments of `evpose live`.

use std::net::SocketAddr;
use std::path::PathBuf;

use crate::args::DeviceArgs;
use crate::outputs::OutputFile;
use crate::ranges::{hertz, milliseconds, seconds, within, zero_or};
use crate::tasks::opening::OpeningArgs;
use crate::tasks::{Live, TaskArgs};

/// Arguments of `evpose live`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    evpose live --source rec.raw --checkpoint body --json -\n  \
    evpose live --source rec.aedat4 --speed 0.5 --checkpoint runs/hand --csv poses.csv\n  \
    evpose live --source tcp://127.0.0.1:7777 --checkpoint runs/hand --serve\n  \
    cat rec.evs | evpose live --source - --checkpoint body --json -\n  \
    evpose live --source camera --checkpoint runs/body/finetune --serve\n\n\
    Each pose has an `origin`, `network`, or `propagated` or `held` between two of those; these are counted \
    separately. Of cameras, \
    connections and --real-time, the oldest events, inputs of the network, and poses for slow outputs are \
    dropped under load, and counted. Files and standard input wait instead.")]
pub struct LiveArgs {
    /// FILE, tcp://HOST:PORT (DV, or plain framed events), - for standard input, or camera (feature
    /// `live`)
    #[arg(long)]
    pub(crate) source: String,
    /// A run directory, a .bpk file, or the name of a shipped network: `hand`, `body`, …
    #[arg(long)]
    pub(crate) checkpoint: PathBuf,
    /// Task that the checkpoint must be of, `hand` or `body` [default: any]
    #[arg(long)]
    pub(crate) task: Option<String>,
    /// Playback speed of a recording; `max` for as fast as possible
    #[arg(long, default_value = "1", value_parser = speed)]
    pub(crate) speed: f64,
    /// Repetitions of a recording
    #[arg(long, default_value_t = 1, value_parser = within(1..=1_000_000_000_u64))]
    pub(crate) times: u64,
    /// Files and standard input: drop events that are not processed in time, as with a camera.
    /// Without this they wait, no event is lost, and `--speed max` and standard input infer every
    /// stride
    #[arg(long)]
    pub(crate) real_time: bool,
    /// Write poses as JSON Lines to a file, which has its name when all is written, - for standard output, or
    /// tcp://HOST:PORT
    #[arg(long, value_name = "OUTPUT")]
    pub(crate) json: Option<OutputFile>,
    /// Write poses as CSV to a file, - for standard output, or tcp://HOST:PORT
    #[arg(long, value_name = "OUTPUT")]
    pub(crate) csv: Option<OutputFile>,
    /// Serve a web page that shows events, poses and latencies; 0.0.0.0:8765 lets other machines
    /// connect, by its address or a name of --host
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = "127.0.0.1:8765")]
    pub(crate) serve: Option<SocketAddr>,
    /// Name of this machine under which the page is served too, such as camera.local (may be repeated)
    #[arg(long, value_name = "NAME", requires = "serve")]
    pub(crate) host: Vec<String>,
    /// Send events, poses and latencies to a running Rerun viewer, by default on this machine, or
    /// write them to FILE.rrd (feature `rerun`)
    #[arg(long, value_name = "VIEWER", num_args = 0..=1, require_equals = true)]
    pub(crate) rerun: Option<Option<String>>,
    /// Propagated poses per second; 0 for none [default: bodies 500, hands 1000]
    #[arg(long, value_parser = zero_or(hertz()))]
    pub(crate) propagate_hz: Option<f64>,
    /// Minimum event time from one inference to the next, in milliseconds
    #[arg(long, default_value_t = 1.0, value_parser = milliseconds())]
    pub(crate) stride_ms: f64,
    /// Capacity of the event queue in packets
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) queue: u16,
    /// End after so many seconds without events
    #[arg(long, value_name = "SECONDS", value_parser = seconds())]
    pub(crate) give_up: Option<f64>,
    /// End after so many seconds: of a recording those of its events, otherwise those of the clock
    #[arg(long, value_parser = seconds())]
    pub(crate) seconds: Option<f64>,
    /// Write the final report as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<OutputFile>,
    #[command(flatten)]
    pub(crate) own: TaskArgs<Live>,
    // Apart, so that the commands are of about one size.
    #[command(flatten)]
    pub(crate) opening: Box<OpeningArgs>,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

fn speed(text: &str) -> Result<f64, String> {
    if text == "max" {
        return Ok(f64::INFINITY);
    }
    within(1e-3..=1e6)(text).map_err(|error| error + ", or `max`")
}
