//! Arguments of `evpose check-labels`.

use std::path::PathBuf;

use evpose_core::SensorSize;
use evpose_datasets::check::CheckOptions;

use crate::commands::opening::parse_size;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose check-labels data/eh36m\n  \
    evpose check-labels data/mpii/poses.json --json findings.json\n  \
    evpose check-labels data/people/0000.poses.csv --frozen-frames 200\n  \
    evpose check-labels EH36M/cam2_S9_Walking_1/ch2GT50Hzskeleton --image-size 640x480\n\n\
    What is found is suspected, no more: a limb that points at the camera is short, and who stands\n\
    still in whole pixels is frozen.\n\nEnds with code 0 where nothing is found, and with 2 where something is.")]
pub(crate) struct CheckLabelsArgs {
    /// Annotations (.json), poses of simulated people (.poses.csv), YARP folders of skeletons, or
    /// directories of any of these
    #[arg(required = true)]
    pub(crate) paths: Vec<PathBuf>,
    /// Where to write all findings
    #[arg(long)]
    pub(crate) json: Option<PathBuf>,
    /// Size of the images [default: of images beside annotations, of the sensor of simulated people, of
    /// eH3.6M's clips]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) image_size: Option<SensorSize>,
    /// Skeletons have rows before columns, as published logs of DHP19
    #[arg(long)]
    pub(crate) transposed: bool,
    #[command(flatten)]
    pub(crate) thresholds: ThresholdArgs,
}

/// When a label is suspected.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "When a label is suspected")]
pub(crate) struct ThresholdArgs {
    /// A limb is so many spreads longer or shorter than the median of its length
    #[arg(long, value_name = "SPREADS", value_parser = not_negative,
        default_value_t = CheckOptions::default().outlier_spreads)]
    outlier_spreads: f32,
    /// The spread is taken for no smaller than this part of the median
    #[arg(long, value_name = "PART", value_parser = not_negative,
        default_value_t = CheckOptions::default().least_spread)]
    least_spread: f32,
    /// The torso is the median over so many frames before and behind
    #[arg(long, value_name = "FRAMES", default_value_t = CheckOptions::default().torso_frames)]
    torso_frames: usize,
    /// With left and right swapped, joints go less than this part of the way
    #[arg(long, value_name = "PART", value_parser = not_negative,
        default_value_t = CheckOptions::default().swap_ratio)]
    swap_ratio: f32,
    /// And the way gets shorter by this many torsos
    #[arg(long, value_name = "TORSOS", value_parser = not_negative,
        default_value_t = CheckOptions::default().swap_gain)]
    swap_gain: f32,
    /// A joint is at the very same place for so many frames
    #[arg(long, value_name = "FRAMES", value_parser = at_least_two,
        default_value_t = CheckOptions::default().frozen_frames)]
    frozen_frames: usize,
    /// And another one moves by this many torsos meanwhile
    #[arg(long, value_name = "TORSOS", value_parser = not_negative,
        default_value_t = CheckOptions::default().frozen_motion)]
    frozen_motion: f32,
    /// Frames further apart than this do not follow each other
    #[arg(long, value_name = "SECONDS", value_parser = seconds,
        default_value_t = CheckOptions::default().gap_s)]
    gap: f64,
}

impl ThresholdArgs {
    pub(super) fn options(&self) -> CheckOptions {
        let &Self {
            outlier_spreads,
            least_spread,
            torso_frames,
            swap_ratio,
            swap_gain,
            frozen_frames,
            frozen_motion,
            gap: gap_s,
        } = self;
        CheckOptions {
            outlier_spreads,
            least_spread,
            torso_frames,
            swap_ratio,
            swap_gain,
            frozen_frames,
            frozen_motion,
            gap_s,
        }
    }
}

fn not_negative(text: &str) -> Result<f32, String> {
    let number = text.parse().ok().filter(|number: &f32| *number >= 0.0);
    number.ok_or_else(|| "a number from 0 on is expected".to_owned())
}

fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number >= 0.0);
    number.ok_or_else(|| "a number of seconds from 0 on is expected".to_owned())
}

fn at_least_two(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|number: &usize| *number >= 2);
    number.ok_or_else(|| "a whole number from 2 on is expected".to_owned())
}
