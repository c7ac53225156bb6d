//! What `evpose bench live` takes.

use std::path::PathBuf;

use evpose_app::args::DeviceArgs;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    evpose bench live --checkpoint checkpoints/body-quick.bpk\n  \
    evpose bench live --task hand --speeds 1,10 --seconds 20 --json live.json\n  \
    evpose bench live --source rec.raw --checkpoint runs/body/finetune --speeds 1\n  \
    evpose bench live --soak 1e9\n\n\
    Without --source, somebody is simulated before a camera held by hand, and events are left out or noise\n\
    is added until there are as many as --rate says. Without --checkpoint, the network has the published\n\
    size and random weights. Latency is from when the newest event of a pose was due to when the pose was\n\
    known.")]
pub struct BenchLiveArgs {
    /// Whose poses; a checkpoint knows
    #[arg(long, default_value = "body")]
    pub(crate) task: String,
    /// A run directory or a .bpk file [default: the published network, not trained]
    #[arg(long)]
    pub(crate) checkpoint: Option<PathBuf>,
    /// A recording [default: one that is made]
    #[arg(long)]
    pub(crate) source: Option<PathBuf>,
    /// Events a second of the recording that is made
    #[arg(long, default_value_t = 5e6)]
    pub(crate) rate: f64,
    /// How fast it is played, one row each
    #[arg(long, value_delimiter = ',', default_values_t = [1.0, 2.0, 5.0, 10.0])]
    pub(crate) speeds: Vec<f64>,
    /// Length of a row
    #[arg(long, default_value_t = 10.0)]
    pub(crate) seconds: f64,
    /// Also time the input alone: events a second, in millions, one row each
    #[arg(long, value_delimiter = ',', value_name = "MILLIONS", default_values_t = [10.0, 20.0, 40.0, 80.0])]
    pub(crate) input: Vec<f64>,
    /// Instead: play so many events as fast as they are followed, and watch the memory
    #[arg(long, value_name = "EVENTS")]
    pub(crate) soak: Option<f64>,
    /// Where to write the numbers
    #[arg(long)]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}
