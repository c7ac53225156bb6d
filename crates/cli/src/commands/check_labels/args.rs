//! Arguments of `evpose check-labels`.

use std::path::PathBuf;

use crate::outputs::OutputFile;
use crate::ranges::{since_start, within};
use crate::tasks::opening::parse_size;
use evpose_core::SensorSize;
use evpose_datasets::check::CheckOptions;

/// Arguments of `evpose check-labels`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose check-labels data/eh36m\n  \
    evpose check-labels data/mpii/poses.json --json findings.json\n  \
    evpose check-labels data/people/0000.poses.csv --frozen-frames 200\n  \
    evpose check-labels EH36M/cam2_S9_Walking_1/ch2GT50Hzskeleton --image-size 640x480\n\n\
    Findings may be false alarms: a limb that points at the camera is short, and a person who stands \
    still has constant integer labels.\n\nExit codes: 0 without findings, 2 with findings.")]
pub struct CheckLabelsArgs {
    /// Annotations (.json), tables of poses (.poses.csv; by name also .csv and .jsonl), YARP folders of
    /// skeletons, or directories of any of these
    #[arg(required = true)]
    pub(crate) paths: Vec<PathBuf>,
    /// Where to write the findings as JSON
    #[arg(long)]
    pub(crate) json: Option<OutputFile>,
    /// Size of the images [default: from the images beside annotations, the sensor of simulated
    /// people, or the published size of eH3.6M]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) image_size: Option<SensorSize>,
    /// Skeletons store rows before columns, as the published logs of DHP19 do
    #[arg(long)]
    pub(crate) transposed: bool,
    #[command(flatten)]
    pub(crate) thresholds: ThresholdArgs,
}

/// Thresholds of findings.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Thresholds")]
pub(crate) struct ThresholdArgs {
    /// Limb length: maximum deviation from its median, in robust standard deviations
    #[arg(long, value_name = "SPREADS", value_parser = within(0.0..=1e6_f32),
        default_value_t = CheckOptions::default().outlier_spreads)]
    outlier_spreads: f32,
    /// Limb length: minimum robust standard deviation, relative to the median
    #[arg(long, value_name = "FRACTION", value_parser = within(0.0..=1e6_f32),
        default_value_t = CheckOptions::default().min_spread)]
    min_spread: f32,
    /// Torso size: median over so many frames before and after
    #[arg(long, value_name = "FRAMES", default_value_t = CheckOptions::default().torso_frames, value_parser = within(0..=1_000_000_usize))]
    torso_frames: usize,
    /// Swapped sides: maximum path length after swapping, relative to that before
    #[arg(long, value_name = "FRACTION", value_parser = within(0.0..=1e6_f32),
        default_value_t = CheckOptions::default().swap_ratio)]
    swap_ratio: f32,
    /// Swapped sides: minimum reduction of path length, in torso sizes
    #[arg(long, value_name = "TORSOS", value_parser = within(0.0..=1e6_f32),
        default_value_t = CheckOptions::default().swap_gain)]
    swap_gain: f32,
    /// Frozen joint: minimum number of frames at the same position
    #[arg(long, value_name = "FRAMES", value_parser = within(2..=1_000_000_usize),
        default_value_t = CheckOptions::default().frozen_frames)]
    frozen_frames: usize,
    /// Frozen joint: minimum motion of another joint meanwhile, in torso sizes
    #[arg(long, value_name = "TORSOS", value_parser = within(0.0..=1e6_f32),
        default_value_t = CheckOptions::default().frozen_motion)]
    frozen_motion: f32,
    /// Maximum time between consecutive frames
    #[arg(long, value_name = "SECONDS", value_parser = since_start(),
        default_value_t = CheckOptions::default().gap_s)]
    gap: f64,
}

impl ThresholdArgs {
    pub(super) fn options(&self) -> CheckOptions {
        CheckOptions {
            outlier_spreads: self.outlier_spreads,
            min_spread: self.min_spread,
            torso_frames: self.torso_frames,
            swap_ratio: self.swap_ratio,
            swap_gain: self.swap_gain,
            frozen_frames: self.frozen_frames,
            frozen_motion: self.frozen_motion,
            gap_s: self.gap,
            ..CheckOptions::default()
        }
    }
}
