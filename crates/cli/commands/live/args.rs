//! What `evpose live` takes.

use std::net::SocketAddr;
use std::path::PathBuf;

use evpose_infer::Precision;

use crate::commands::opening::OpeningArgs;
use evpose_app::args::DeviceArgs;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    evpose live --source rec.raw --checkpoint checkpoints/body-quick.bpk --json -\n  \
    evpose live --source rec.aedat4 --speed 0.5 --checkpoint runs/hand --csv poses.csv\n  \
    evpose live --source tcp://127.0.0.1:7777 --checkpoint runs/hand --serve\n  \
    cat rec.evs | evpose live --source - --checkpoint checkpoints/body-quick.bpk --json -\n  \
    evpose live --source camera --checkpoint runs/body/finetune --serve\n\n\
    Poses of the network and poses between them are written with their own `origin`, and counted apart.\n\
    Events that cannot be followed in time are dropped, the oldest first, and counted; so are images for\n\
    which the network had no time, and poses that a sink could not take.")]
pub(crate) struct LiveArgs {
    /// FILE, tcp://HOST:PORT (DV, or plain framed events), - for standard input, or camera (feature
    /// `live`)
    #[arg(long)]
    pub(crate) source: String,
    /// A run directory or a .bpk file
    #[arg(long)]
    pub(crate) checkpoint: PathBuf,
    /// Whose poses; the checkpoint knows
    #[arg(long)]
    pub(crate) task: Option<String>,
    /// Recordings: seconds of it in a second; `max` for as fast as it goes
    #[arg(long, default_value = "1", value_parser = speed)]
    pub(crate) speed: f64,
    /// Recordings: how often it is played
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) times: u64,
    /// Write every pose as a line of JSON: a file, - for standard output, or tcp://HOST:PORT
    #[arg(long, value_name = "WHERE")]
    pub(crate) json: Option<String>,
    /// Write every pose as a line of a table: a file, or - for standard output
    #[arg(long, value_name = "WHERE")]
    pub(crate) csv: Option<String>,
    /// Serve a page that shows events, poses and figures, live; for others than this machine say
    /// 0.0.0.0:8765
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = "127.0.0.1:8765")]
    pub(crate) serve: Option<SocketAddr>,
    /// Send events, poses and figures to a Rerun viewer that runs, by default on this machine, or to a
    /// file of it, FILE.rrd (feature `rerun`)
    #[arg(long, value_name = "WHERE", num_args = 0..=1, require_equals = true)]
    pub(crate) rerun: Option<Option<String>>,
    /// Poses a second between those of the network; 0 for none [default: bodies 500, hands 1000]
    #[arg(long)]
    pub(crate) propagate_hz: Option<f64>,
    /// Least time between two images of the network, in milliseconds of the events
    #[arg(long, default_value_t = 1.0)]
    pub(crate) stride_ms: f64,
    /// Hands: surfaces that the network is shown at once [default: 1 on the CPU, 16 elsewhere]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) batch: Option<u16>,
    /// Bodies: joints of a lower score are not found
    #[arg(long, default_value_t = 0.01)]
    pub(crate) confidence: f32,
    /// Packets that wait at most
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) queue: u16,
    /// End when nothing came for so many seconds
    #[arg(long, value_name = "SECONDS")]
    pub(crate) give_up: Option<f64>,
    /// End after so many seconds
    #[arg(long)]
    pub(crate) seconds: Option<f64>,
    /// Write the report as JSON when it ends
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    /// Bits that the network computes in: f32, bf16, or int8 after `evpose quantize`
    #[arg(long, default_value = "f32")]
    pub(crate) precision: Precision,
    #[command(flatten)]
    pub(crate) opening: OpeningArgs,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

fn speed(text: &str) -> Result<f64, String> {
    if text == "max" {
        return Ok(f64::INFINITY);
    }
    let speed = text.parse().ok().filter(|speed: &f64| *speed > 0.0);
    speed.ok_or_else(|| "a number above 0, or `max`".to_owned())
}
