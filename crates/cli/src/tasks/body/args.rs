//! Arguments that the body task brings to commands.

use std::path::PathBuf;

use evpose_io::poses::PoseFormat;
use evpose_pose::body::JointDefinition;

use crate::outputs::OutputFile;
use crate::ranges::share;
use crate::tasks::args::{
    PoseEvalArgs, PoseInferArgs, PoseLiveArgs, RecordingArgs, StartArgs, written_format,
};

#[derive(Debug, clap::Args)]
pub(crate) struct BodySimulateArgs {
    #[command(flatten)]
    pub(super) recording: RecordingArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct BodyTrainArgs {
    /// Directory of sequences from `evpose simulate`, or of images from `evpose prepare`, or the
    /// annotation file of the latter; for bodies it may be repeated, and the last sequences are for
    /// validation [bodies: simulated into OUT/data where it is missing]
    #[arg(long)]
    pub(super) data: Vec<PathBuf>,
    /// Directory of the run [bodies: the config's `out`]
    #[arg(long)]
    pub(super) out: Option<PathBuf>,
    #[command(flatten)]
    pub(super) start: StartArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct BodyEvalArgs {
    #[command(flatten)]
    pub(super) own: PoseEvalArgs,
    /// Draw true and predicted joints over inputs of the network, as a PNG file; of hands, those of
    /// `--foreign`
    #[arg(long, value_name = "FILE")]
    pub(super) preview: Option<OutputFile>,
    /// Also evaluate poses at 500 Hz, held constant after each inference, and propagated by velocities
    /// from events
    #[arg(long)]
    pub(super) fusion: bool,
    /// On annotated images: also evaluate joints where the labels of `dhp19` put them: the head's on top
    /// of it, the hips' on the crest of the pelvis
    #[arg(long, value_name = "SET", value_parser = joint_definition)]
    pub(super) joints: Option<JointDefinition>,
    /// true: infer a person also in crops of other sizes and in the mirror, for truer joints, seven
    /// inferences for two; false: not [default: the checkpoint's]
    #[arg(long, value_name = "BOOL")]
    pub(super) consensus: Option<bool>,
    /// Plot PCK against its threshold, as an SVG file
    #[arg(long, value_name = "FILE")]
    pub(super) curves: Option<OutputFile>,
}

fn joint_definition(set: &str) -> Result<JointDefinition, String> {
    match set {
        "dhp19" => Ok(JointDefinition::Dhp19),
        _ => Err("there is `dhp19`".to_owned()),
    }
}

#[derive(Debug, clap::Args)]
pub(crate) struct BodyInferArgs {
    #[command(flatten)]
    pub(super) own: PoseInferArgs,
    /// Recording, in any supported format; bodies: several, of calibrated cameras with one clock, for
    /// joints in the world
    #[arg(long, num_args = 1.., required = true)]
    pub(super) events: Vec<PathBuf>,
    /// Format of the output, instead of its ending's: `table` (CSV with a header), `json` (an array of the
    /// same names), `jsonl` (JSON Lines), or, of bodies, `hpe-core` or `yarp` (a folder)
    #[arg(long, value_parser = written_format)]
    pub(super) format: Option<&'static PoseFormat>,
    /// The calibrated cameras of several recordings, a TOML file with a `[[camera]]` for each [default:
    /// the metadata that `evpose simulate` writes beside each]
    #[arg(long, value_name = "FILE")]
    pub(super) cameras: Option<PathBuf>,
    /// Images per call of the network [default: 1 on the CPU, 16 on other devices]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(super) batch: Option<u16>,
    /// Minimum score of a pose and of a joint, 0 to 1; below it, positions are empty [poses and joints:
    /// the checkpoint's]
    #[arg(long, value_name = "SCORE", value_parser = share())]
    pub(super) min_score: Option<f32>,
    /// Minimum score of a joint in the decoder of the network [the checkpoint's]
    #[arg(long, value_parser = share())]
    pub(super) confidence: Option<f32>,
    /// true: infer a person also in crops of other sizes and in the mirror, for truer joints, seven
    /// inferences for two; false: not [default: the checkpoint's]
    #[arg(long, value_name = "BOOL")]
    pub(super) consensus: Option<bool>,
    /// Also write skeletons as a YARP folder
    #[arg(long, value_name = "DIR")]
    pub(super) skeletons: Option<OutputFile>,
    /// Also write poses at 500 Hz, propagated from each inference by velocities from events
    #[arg(long, value_name = "FILE")]
    pub(super) fused: Option<OutputFile>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct BodyLiveArgs {
    #[command(flatten)]
    pub(crate) own: PoseLiveArgs,
    /// Minimum score of a pose and of a joint, 0 to 1; below it, positions are left out [poses and
    /// joints: the checkpoint's]
    #[arg(long, value_name = "SCORE", value_parser = share())]
    pub(crate) min_score: Option<f32>,
    /// Minimum score of a joint in the decoder of the network [the checkpoint's]
    #[arg(long, value_parser = share())]
    pub(super) confidence: Option<f32>,
    /// Infer a person also in crops of other sizes and in the mirror, as `evpose infer` does: truer joints,
    /// seven inferences for two
    #[arg(long)]
    pub(super) consensus: bool,
}
