//! Arguments that the hand task brings to commands.

use std::path::PathBuf;

use crate::outputs::OutputFile;
use crate::ranges::{count, seconds, share};
use crate::tasks::args::{
    DirectoryArgs, OneRecordingArgs, PoseEvalArgs, PoseInferArgs, PoseLiveArgs, RecordingArgs,
    StartArgs,
};

#[derive(Debug, clap::Args)]
pub(crate) struct HandSimulateArgs {
    #[command(flatten)]
    pub(super) recording: RecordingArgs,
    /// A condition to record under (`evpose eval --help` lists them), or a TOML file of one
    #[arg(long)]
    pub(super) condition: Option<String>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct HandTrainArgs {
    #[command(flatten)]
    pub(super) directories: DirectoryArgs,
    #[command(flatten)]
    pub(super) start: StartArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct HandEvalArgs {
    #[command(flatten)]
    pub(super) own: PoseEvalArgs,
    /// Draw true and predicted joints over inputs of the network for recordings of `--foreign`, as a PNG file
    #[arg(long, value_name = "FILE", requires = "foreign")]
    pub(super) preview: Option<OutputFile>,
    /// Simulate sequences under these conditions instead (names below, or TOML files), and compare the
    /// slow-motion mode with the plain pipeline
    #[arg(long, value_delimiter = ',', conflicts_with = "data")]
    pub(super) conditions: Vec<String>,
    /// Where to keep the sequences, metrics and a figure of each condition
    #[arg(long, requires = "conditions")]
    pub(super) out: Option<PathBuf>,
    /// Sequences of each condition
    #[arg(long, default_value_t = 10, requires = "conditions", value_parser = count::<usize>())]
    pub(super) sequences: usize,
    /// Length of each sequence of a condition
    #[arg(long, default_value_t = 6.0, requires = "conditions", value_parser = seconds())]
    pub(super) seconds: f64,
}

#[derive(Debug, clap::Args)]
pub(crate) struct HandInferArgs {
    #[command(flatten)]
    pub(super) own: PoseInferArgs,
    #[command(flatten)]
    pub(super) recording: OneRecordingArgs,
    /// `plain` infers every millisecond; `slow-motion` infers in batches once enough events have
    /// arrived, repeats the last poses of a hand at rest, and smooths a fast hand less
    #[arg(long, default_value = "plain", value_parser = ["plain", "slow-motion"])]
    pub(super) mode: String,
    /// Minimum presence of a hand, 0 to 1, of networks of joints; below it, rows are of nobody [the checkpoint's]
    #[arg(long, value_name = "SCORE", value_parser = share())]
    pub(super) min_score: Option<f32>,
    #[command(flatten)]
    pub(super) length: HandLength,
    /// Also write a table of the joints alone, without parameters
    #[arg(long)]
    pub(super) joints: Option<OutputFile>,
    /// Also write a table of full MANO poses: position and rotation of the wrist and the 45 rotations of all other
    /// joints, of the hand that is fitted to the joints of a network of joints
    #[arg(long, value_name = "FILE")]
    pub(super) rotations: Option<OutputFile>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct HandLiveArgs {
    #[command(flatten)]
    pub(super) own: PoseLiveArgs,
    #[command(flatten)]
    pub(super) length: HandLength,
}

#[derive(Debug, Clone, Copy, clap::Args)]
pub(super) struct HandLength {
    /// Length of the hand in mm, from the wrist along the bones to the tip of the middle finger: metres are
    /// those of such a hand, since an image does not say how far away it is. The mean hand's otherwise
    #[arg(long, value_name = "MM", value_parser = clap::value_parser!(u16).range(50..=400))]
    pub(super) hand_length_mm: Option<u16>,
}

impl HandLength {
    /// In metres.
    pub(super) fn metres(self) -> Option<f32> {
        self.hand_length_mm.map(|mm| 1e-3 * f32::from(mm))
    }
}
