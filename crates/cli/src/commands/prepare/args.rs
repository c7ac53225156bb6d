//! Arguments of `evpose prepare`.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Subcommand;
use clap::builder::TypedValueParser;
use evpose_datasets::ErosFrameOptions;
use evpose_datasets::dhp19::CameraChoice;

use super::own_args::{HandsArgs, PeopleArgs};
use crate::ranges::{choices, threads, within};

/// Beyond the poses of any recording.
const MAX_EVERY: NonZeroUsize = NonZeroUsize::MIN.saturating_add(999_999);

/// Data sets that can be prepared.
#[derive(Debug, Subcommand)]
#[command(after_help = "Start with:\n  evpose prepare mpii MPII --out data/mpii\n  \
    evpose train pretrain --set data.source=annotations --data data/mpii\n\n\
    or, with recordings of your own (docs/guide/own-labels.md):\n  evpose prepare people walk.raw --labels walk.csv --out data/own\n\n\
    Nothing is downloaded: datasets/README.md describes the sources, licences and folder layouts.")]
pub enum PrepareCommand {
    /// MPII Human Pose: photographs, rendered to look like events or in grey
    Mpii(MpiiArgs),
    /// Leeds Sports Pose, the original or the extended set: photographs, rendered as MPII's are
    Lsp(LspArgs),
    /// COCO's keypoints of persons: photographs, rendered as MPII's are
    Coco(CocoArgs),
    /// DHP19: movements recorded by four event cameras
    Dhp19(Dhp19Args),
    /// eH3.6M: the published event clips of Human3.6M
    Eh36m(Eh36mArgs),
    /// Human3.6M: videos converted to events, as eH3.6M was made
    H36m(H36mArgs),
    /// Your own recordings of people, with joints as COCO or MPII annotations or CSV
    People(PeopleArgs),
    /// Your own recordings of hands, with 21 joints in 2D or 3D or 12 parameters as CSV
    Hands(HandsArgs),
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose prepare mpii MPII --out data/mpii\n  \
    evpose prepare mpii MPII --out data/mpii-grey --grey\n  \
    evpose prepare mpii MPII --out data/mpii-published --parity --jpeg 95\n\n\
    OUT/images has an image of each person, OUT/poses.json its label, OUT/conversion.json the skipped \
    persons with reasons. An interrupted conversion is continued by the same command.")]
pub struct MpiiArgs {
    /// Folder with images/ and mpii_human_pose_v1_u12_1.mat, the latter perhaps in
    /// mpii_human_pose_v1_u12_2/
    pub(crate) data: PathBuf,
    #[command(flatten)]
    pub(crate) stills: StillArgs,
    /// Reproduce the labels of the published program, including its errors
    #[arg(long)]
    pub(crate) parity: bool,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose prepare lsp lspet --out data/lspet\n  \
    evpose prepare lsp lsp_dataset --out data/lsp --seed 1\n\n\
    OUT/images has an image of each person, OUT/poses.json its label, OUT/conversion.json the skipped \
    persons with reasons. An interrupted conversion is continued by the same command.")]
pub struct LspArgs {
    /// Folder with images/ and joints.mat
    pub(crate) data: PathBuf,
    #[command(flatten)]
    pub(crate) stills: StillArgs,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose prepare coco COCO --out data/coco\n  \
    evpose prepare coco COCO --split val2017 --out data/coco-val\n  \
    evpose prepare coco mine --annotations mine/keypoints.json --images mine/frames --out data/mine\n\n\
    OUT/images has an image of each person, OUT/poses.json its label, OUT/conversion.json the skipped \
    persons with reasons. An interrupted conversion is continued by the same command.")]
pub struct CocoArgs {
    /// Folder with annotations/person_keypoints_SPLIT.json and SPLIT/
    pub(crate) data: PathBuf,
    /// Part of the set
    #[arg(long, default_value = "train2017")]
    pub(crate) split: String,
    #[command(flatten)]
    pub(crate) stills: StillArgs,
}

/// Arguments of the data sets of photographs.
#[derive(Debug, clap::Args)]
pub(crate) struct StillArgs {
    /// The folder of photographs [default: that of the set in DATA]
    #[arg(long, value_name = "DIR")]
    pub(crate) images: Option<PathBuf>,
    /// The file of annotations [default: that of the set in DATA]
    #[arg(long, value_name = "FILE")]
    pub(crate) annotations: Option<PathBuf>,
    /// Folder to write
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Grey photographs: the baseline without event-like rendering
    #[arg(long)]
    pub(crate) grey: bool,
    /// Write JPEG images of this quality, 1 to 100, instead of PNG; published ones have 95
    #[arg(long, value_name = "QUALITY", value_parser = clap::value_parser!(u8).range(1..=100))]
    pub(crate) jpeg: Option<u8>,
    /// Seed of the noise
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// CPU threads; all cores by default. The bytes written do not depend on it
    #[arg(long, value_parser = threads())]
    pub(crate) threads: Option<usize>,
}

/// Arguments of the data sets of recordings.
#[derive(Debug, clap::Args)]
pub(crate) struct FrameSetArgs {
    /// Folder to write: EROS images in eros/, their labels in train.json and test.json
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Reproduce the published programs, including their errors, to compare with published results
    #[arg(long)]
    pub(crate) parity: bool,
    /// Use every N-th pose [default: 10 for DHP19 at 100 Hz, else 1 at 50 Hz]
    #[arg(long, value_name = "N", value_parser = within(NonZeroUsize::MIN..=MAX_EVERY))]
    pub(crate) every: Option<NonZeroUsize>,
    /// Only these subjects, for example 1,5,9
    #[arg(long, value_delimiter = ',', value_name = "SUBJECTS")]
    pub(crate) subjects: Vec<u8>,
    /// CPU threads, each with a recording in memory; all cores by default. The bytes written do not
    /// depend on it
    #[arg(long, value_parser = threads())]
    pub(crate) threads: Option<usize>,
}

impl FrameSetArgs {
    /// Options of the frames; `every` is the default stride of poses.
    pub(super) fn options(&self, every: NonZeroUsize) -> ErosFrameOptions {
        let options =
            if self.parity { ErosFrameOptions::PUBLISHED } else { ErosFrameOptions::default() };
        ErosFrameOptions { every: self.every.unwrap_or(every), ..options }
    }

    /// Whether a subject is selected.
    pub(super) fn takes(&self, subject: u8) -> bool {
        self.subjects.is_empty() || self.subjects.contains(&subject)
    }
}

fn cameras() -> impl TypedValueParser<Value = CameraChoice> {
    choices([
        ("front", "2 and 3, before the person: those of published results", CameraChoice::Front),
        ("side", "0 and 1, beside the person", CameraChoice::Side),
        ("all", "All four", CameraChoice::All),
    ])
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose prepare dhp19 DHP19 --out data/dhp19\n  \
    evpose prepare dhp19 DHP19 --out data/side --cameras side --subjects 1,2,13\n  \
    evpose prepare dhp19 DHP19 --extracted DHP19/mat --out data/published --parity --every 11\n\n\
    Persons 13 to 17 are tested on. OUT/conversion.json says what was left out and why.")]
pub struct Dhp19Args {
    /// Folder with DVS_movies/S1/session1/mov1.aedat and so on, Vicon_data/S1_1_1.mat and so on,
    /// and P_matrices/P1.npy to P4.npy
    pub(crate) data: PathBuf,
    /// The folder of projections [default: DATA/P_matrices]
    #[arg(long, value_name = "DIR")]
    pub(crate) projections: Option<PathBuf>,
    /// Instead of movies: a folder of S1_1_1.mat and so on, cut and filtered by hpe-core's
    /// preprocess.m
    #[arg(long, value_name = "DIR")]
    pub(crate) extracted: Option<PathBuf>,
    /// Cameras
    #[arg(long, value_parser = cameras(), default_value = "front")]
    pub(crate) cameras: CameraChoice,
    /// Read the intact parts of damaged movies, and report what is lost
    #[arg(long, conflicts_with = "extracted")]
    pub(crate) salvage: bool,
    #[command(flatten)]
    pub(crate) frames: FrameSetArgs,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose prepare eh36m EH36M --out data/eh36m\n  \
    evpose prepare eh36m EH36M --out data/eh36m-published --parity\n\n\
    Persons 9 and 11 are tested on. OUT/conversion.json says what was left out and why.")]
pub struct Eh36mArgs {
    /// Folder of clips: cam2_S9_Walking_1/ch0dvs, cam2_S9_Walking_1/ch2GT50Hzskeleton and so on
    pub(crate) data: PathBuf,
    /// Microseconds per tick of the logs' clock, 0.08 or 1, for logs that do not state it
    #[arg(long, value_name = "MICROSECONDS", value_parser = within(1e-3..=1e6))]
    pub(crate) tick_us: Option<f64>,
    #[command(flatten)]
    pub(crate) frames: FrameSetArgs,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose prepare h36m H36M --out data/h36m\n  \
    evpose prepare h36m H36M --out data/h36m --yarp --seed 7 --subjects 1,9\n\n\
    Videos are not read: their frames are, as 000001.jpg and so on in a folder called like the \
    video without .mp4. With ffmpeg, in the folder of the set:\n  \
    for v in S*/Videos/*.mp4; do\n    \
    mkdir \"${v%.mp4}\" && ffmpeg -i \"$v\" -q:v 2 \"${v%.mp4}/%06d.jpg\"\n  done\n\n\
    Persons 9 and 11 are tested on. OUT/conversion.json says what was left out and why.")]
pub struct H36mArgs {
    /// Folder with S9/Poses_D2_Positions/Walking 1.55011271.cdf and so on
    pub(crate) data: PathBuf,
    /// Folder with S9/Videos/Walking 1.55011271/ and so on, each with the frames of a video
    /// [default: DATA]
    #[arg(long, value_name = "DIR")]
    pub(crate) videos: Option<PathBuf>,
    /// Also write events and joints in the format of eH3.6M, into OUT/yarp
    #[arg(long)]
    pub(crate) yarp: bool,
    /// Seed of the sensor
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) frames: FrameSetArgs,
}
