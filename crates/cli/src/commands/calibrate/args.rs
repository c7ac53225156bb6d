//! Arguments of `evpose calibrate`.

use std::path::PathBuf;

use crate::tasks::opening::OpeningArgs;
use evpose_camera::calibrate::threshold::FLOOR;

use crate::commands::opening::FrameArgs;
use crate::outputs::OutputFile;
use crate::ranges::{since_start, within};

/// Subcommands of `evpose calibrate`.
#[derive(Debug, clap::Subcommand)]
#[command(after_help = "Start with:\n  \
    evpose calibrate threshold --events board.npz --frames board/ --fps 60 --encoding srgb\n  \
    evpose calibrate noise --events wall.npz")]
pub enum CalibrateCommand {
    /// Contrast thresholds, from frames and events of a moving pattern
    Threshold(ThresholdArgs),
    /// Noise rates and hot pixels, from a recording of a static scene
    Noise(NoiseArgs),
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    evpose calibrate threshold --events board.npz --frames board/ --fps 60 --encoding srgb\n  \
    evpose calibrate threshold --events rec.npz --frames frames.npy --fps 1000 --out camera.toml\n\n\
    Move a checkerboard slowly in front of the camera. `by totals` divides the total change of log light \
    by the number of events (EventHands, eqs. 7 and 8); `by steps` is the median change between two \
    events of a pixel, which noise events and reversals of the light hardly change.")]
pub struct ThresholdArgs {
    /// Recording in any supported format
    #[arg(long)]
    pub(crate) events: PathBuf,
    #[command(flatten)]
    pub(crate) opening: OpeningArgs,
    #[command(flatten)]
    pub(crate) frames: FrameArgs,
    /// Noise floor of the frames, relative to white: darker luminance is clamped to this
    #[arg(long, default_value_t = FLOOR, value_parser = within(1e-6..=0.999_f32))]
    pub(crate) floor: f32,
    /// Where to write a sensor with these thresholds as TOML
    #[arg(long)]
    pub(crate) out: Option<OutputFile>,
    /// Seed of the bootstrap
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose calibrate noise --events wall.npz\n  \
    evpose calibrate noise --events wall.npz --skip 0.5 --out noise.toml --hot hot.csv\n\n\
    Point the camera at a wall, in light that does not flicker, for a minute.")]
pub struct NoiseArgs {
    /// Recording in any supported format
    #[arg(long)]
    pub(crate) events: PathBuf,
    #[command(flatten)]
    pub(crate) opening: OpeningArgs,
    /// Seconds skipped at the beginning
    #[arg(long, default_value_t = 0.0, value_parser = since_start())]
    pub(crate) skip: f64,
    /// Where to write a sensor with these rates as TOML
    #[arg(long)]
    pub(crate) out: Option<OutputFile>,
    /// Where to write hot pixels as CSV: column, row, ON and OFF events per second
    #[arg(long)]
    pub(crate) hot: Option<OutputFile>,
    /// Seed of the bootstrap
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
}
