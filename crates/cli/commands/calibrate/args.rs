//! Arguments of `evpose calibrate`.

use std::path::PathBuf;

use evpose_calibrate::threshold::FLOOR;

use crate::commands::opening::FrameArgs;

#[derive(Debug, clap::Subcommand)]
pub(crate) enum CalibrateCommand {
    /// Contrast thresholds, from frames and events of a moving pattern
    Threshold(ThresholdArgs),
    /// Background rates and hot pixels, from a recording of a scene at rest
    Noise(NoiseArgs),
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    evpose calibrate threshold --events board.npz --frames board/ --fps 60 --encoding srgb\n  \
    evpose calibrate threshold --events rec.npz --frames frames.npy --fps 1000 --out camera.toml\n\n\
    Move a checkerboard slowly in front of the camera. `by totals` takes all change of light over all\n\
    events (EventHands, eqs. 7 and 8); `by steps` the median change between two events of a pixel,\n\
    which noise and what is left at turns do not touch.")]
pub(crate) struct ThresholdArgs {
    /// Events of any format
    #[arg(long)]
    pub(crate) events: PathBuf,
    #[command(flatten)]
    pub(crate) frames: FrameArgs,
    /// Light below this share of white is taken to be this: where frames show noise
    #[arg(long, default_value_t = FLOOR)]
    pub(crate) floor: f32,
    /// A sensor with these thresholds (by steps), as TOML
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
    /// Seed of the intervals
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose calibrate noise --events wall.npz\n  \
    evpose calibrate noise --events wall.npz --skip 0.5 --out noise.toml --hot hot.csv\n\n\
    Point the camera at a wall, in light that does not flicker, for a minute.")]
pub(crate) struct NoiseArgs {
    /// Events of any format
    #[arg(long)]
    pub(crate) events: PathBuf,
    /// Seconds at the beginning that do not count
    #[arg(long, default_value_t = 0.0)]
    pub(crate) skip: f64,
    /// These rates as effects of a sensor, as TOML
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
    /// Hot pixels as CSV: column, row, ON and OFF events per second
    #[arg(long)]
    pub(crate) hot: Option<PathBuf>,
    /// Seed of the intervals
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
}
