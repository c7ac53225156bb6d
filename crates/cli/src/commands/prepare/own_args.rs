//! Arguments of `evpose prepare people` and `evpose prepare hands`.

use std::path::{Path, PathBuf};

use crate::outputs::write_file;
use crate::ranges::{choices, hertz, within};
use crate::tasks::opening::OpeningArgs;
use anyhow::{Context, Result, bail};
use clap::builder::TypedValueParser;
use evpose_core::{Micros, temporary_target};
use evpose_datasets::import::{FrameCount, LabelClock};
use evpose_pose::{HandSide, JointFrame};

/// Names of files beside sequences, which a sequence cannot have.
const RESERVED: [&str; 2] = ["run", "config"];
/// The file that is in a directory while the first import into it goes on.
const UNFINISHED: &str = "unfinished";

/// Clocks may count from 1970: this is the year 2255.
const MAX_START_US: i64 = 1 << 53;

/// Recordings and label files, in the same order.
#[derive(Debug, clap::Args)]
pub(crate) struct OwnRecordingArgs {
    /// Recordings, in any supported format; `evpose convert --help` lists them
    #[arg(required = true)]
    pub(crate) recordings: Vec<PathBuf>,
    /// Label file of each recording, in the same order
    #[arg(long, required = true, num_args = 1.., value_name = "FILE")]
    pub(crate) labels: Vec<PathBuf>,
    /// Directory to write into; other recordings may be there already
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Time of the labels' 0 in the clock of the events, in microseconds
    #[arg(long, value_name = "MICROSECONDS", default_value_t = 0, allow_hyphen_values = true,
        value_parser = within(-MAX_START_US..=MAX_START_US))]
    pub(crate) start_us: i64,
    /// Longest time between labels over which they are interpolated; a recording is cut at longer
    /// gaps
    #[arg(long, value_name = "MILLISECONDS", default_value_t = 100,
        value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) max_gap_ms: u32,
}

pub(super) struct Import {
    /// Whether sequences that are there are those of an import that was killed, so that they are written again.
    pub(super) replaces: bool,
    folder: PathBuf,
}

impl Import {
    /// Ends it.
    pub(super) fn end(self) -> Result<()> {
        let mark = self.folder.join(UNFINISHED);
        if mark.exists() {
            std::fs::remove_file(&mark).with_context(|| format!("removing {}", mark.display()))?;
        }
        Ok(())
    }
}

impl Drop for Import {
    fn drop(&mut self) {
        // What failed before it wrote anything leaves nothing; a folder with more in it stays as it is.
        let mut names =
            self.folder.read_dir().into_iter().flatten().flatten().map(|entry| entry.file_name());
        if names.all(|name| name == UNFINISHED) {
            let _ = std::fs::remove_file(self.folder.join(UNFINISHED));
            let _ = std::fs::remove_dir(&self.folder);
        }
    }
}

impl OwnRecordingArgs {
    /// Each recording with its label file and the name of its sequences.
    pub(super) fn pairs(&self) -> Result<Vec<(&Path, &Path, String)>> {
        let (recordings, labels) = (self.recordings.len(), self.labels.len());
        if recordings != labels {
            bail!("{recordings} recordings, but --labels names {labels} files: each has its own");
        }
        let mut pairs: Vec<(&Path, &Path, String)> = Vec::new();
        for (recording, labels) in self.recordings.iter().zip(&self.labels) {
            let name = recording.file_stem().and_then(|stem| stem.to_str());
            let name = name.with_context(|| format!("{}: no name", recording.display()))?;
            // Sequences have the names of their recordings, and would overwrite each other.
            if pairs.iter().any(|(_, _, other)| other == name) {
                bail!("two recordings are called `{name}`: rename one, or give it another --out");
            }
            // `run.toml` beside the sequences says how they were made.
            if RESERVED.contains(&name) {
                bail!(
                    "{}: `{name}.toml` is a record of the directory: rename it",
                    recording.display()
                );
            }
            pairs.push((recording, labels, name.to_owned()));
        }
        Ok(pairs)
    }

    pub(super) fn begin(&self) -> Result<Import> {
        let mark = self.out.join(UNFINISHED);
        let words: Vec<_> = std::env::args_os().skip(1).collect();
        let command = format!("{words:?}");
        let mut names =
            self.out.read_dir().into_iter().flatten().flatten().map(|entry| entry.file_name());
        // Of a directory with recordings, nothing is written over.
        if names.all(|name| name.to_str().and_then(temporary_target).is_some()) {
            write_file(&mark, &command)?;
        }
        // Another command is another import, whose sequences may have the same names.
        let replaces = std::fs::read(&mark).is_ok_and(|before| before == command.as_bytes());
        Ok(Import { replaces, folder: self.out.clone() })
    }

    /// The longest time over which labels are interpolated.
    pub(super) fn max_gap(&self) -> Micros {
        Micros(1_000 * i64::from(self.max_gap_ms))
    }
}

fn counts() -> impl TypedValueParser<Value = FrameCount> {
    choices([
        ("name", "The last digits of each file_name", FrameCount::Name),
        ("order", "The order of the file", FrameCount::Order),
    ])
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Label formats, detected:\n  \
    csv        t_us or t_s, then JOINT_u_px and JOINT_v_px of any of: head, shoulder_l, shoulder_r,\n             \
    elbow_l, …, wrist_l, …, hip_l, …, knee_l, …, ankle_l, …\n  \
    coco       COCO's JSON of keypoints; images with t_us (or timestamp_us), or --fps\n  \
    mpii-json  a JSON list of image, joints and joints_vis in MPII's order, with t_us or --fps\n  \
    mpii       MPII's MAT-file, with --fps\n\n\
    Examples:\n  \
    evpose prepare people walk.aedat4 --labels walk.csv --out data/own\n  \
    evpose prepare people jump.raw --labels coco.json --fps 30 --start-us 1200000 --out data/own\n  \
    evpose check-labels data/own\n  \
    evpose train body-wide --data data/own --start-from checkpoints/body-quick.bpk --out runs/own\n\n\
    docs/guide/own-labels.md has more.")]
pub struct PeopleArgs {
    #[command(flatten)]
    pub(crate) own: OwnRecordingArgs,
    /// Format of the labels, by name [default: detected]
    #[arg(long)]
    pub(crate) format: Option<String>,
    /// Images per second, for labels of images without time stamps: image N is at N / FPS after
    /// --start-us
    #[arg(long, value_parser = hertz())]
    pub(crate) fps: Option<f64>,
    /// Count of images without time stamps [default: by name where every name has digits, else in
    /// order]
    #[arg(long, value_parser = counts(), requires = "fps")]
    pub(crate) count_by: Option<FrameCount>,
    #[command(flatten)]
    pub(crate) opening: OpeningArgs,
}

impl PeopleArgs {
    pub(super) fn clock(&self) -> LabelClock {
        let count = self.count_by.unwrap_or_default();
        LabelClock { start: Micros(self.own.start_us), fps: self.fps, count }
    }
}

fn frames() -> impl TypedValueParser<Value = JointFrame> {
    let camera = "Of the camera, as OpenCV has it: x right, y down, z forwards";
    let world = "Of the simulation's world";
    choices([("camera", camera, JointFrame::Camera), ("world", world, JointFrame::World)])
}

fn sides() -> impl TypedValueParser<Value = HandSide> {
    choices([
        ("right", "The right hand", HandSide::Right),
        ("left", "The left hand", HandSide::Left),
    ])
}

/// Size of a hand relative to the neutral one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum HandScale {
    Given(f64),
    /// From the joints.
    Fitted,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Label formats, detected by their columns, beside t_us or t_s:\n  \
    parameters  articulation_1 to articulation_6, translation_x_m, …, rotation_x_rad, …:\n              \
    the columns of `evpose infer --out`\n  \
    joints      JOINT_x_m, JOINT_y_m, JOINT_z_m in metres, or JOINT_u_px, JOINT_v_px in pixels\n              \
    of the sensor: the columns of `evpose infer --joints`, of which some may be missing\n\n\
    Examples:\n  \
    evpose prepare hands rec.aedat4 --labels joints.csv --for hand-wide \
    \\\n      --camera calibration.yaml --out data/own\n  \
    evpose prepare hands rec.raw --labels joints.csv \
    --for checkpoints/hand-quick.bpk --2d \\\n      --out data/own\n  \
    evpose train quick --data data/own --start-from checkpoints/hand-quick.bpk --out runs/own\n\n\
    docs/guide/own-labels.md has more.")]
pub struct HandsArgs {
    #[command(flatten)]
    pub(crate) own: OwnRecordingArgs,
    /// The network to train: a config by name or file, a run directory or a checkpoint
    #[arg(long = "for", value_name = "CONFIG")]
    pub(crate) target: String,
    /// The camera: a calibration file of OpenCV, ROS, kalibr, DSEC, rpg, dv-processing or this project, a name such as
    /// davis346 or evk4, or a vertical field of view such as 45deg [default: 45deg, with a note]
    #[arg(long)]
    pub(crate) camera: Option<String>,
    /// Side of the hand; a network of the other hand is shown the mirror image
    #[arg(long, value_parser = sides(), default_value = "right")]
    pub(crate) side: HandSide,
    /// Frame of joints in metres, of tables without a column `frame` [default: camera]
    #[arg(long, value_parser = frames())]
    pub(crate) frame: Option<JointFrame>,
    /// Fit to joints in pixels, even if the file has some in metres
    #[arg(long = "2d")]
    pub(crate) on_image: bool,
    /// Size of the hand relative to the neutral one, or `fit`: from joints in metres
    #[arg(long, default_value = "1", value_parser = hand_scale)]
    pub(crate) scale: HandScale,
    #[command(flatten)]
    pub(crate) opening: OpeningArgs,
}

fn hand_scale(text: &str) -> Result<HandScale, String> {
    if text == "fit" {
        return Ok(HandScale::Fitted);
    }
    let value = text.parse().ok().filter(|value| (0.3..=3.0).contains(value));
    value.map(HandScale::Given).ok_or_else(|| "expected `fit` or a value from 0.3 to 3".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sequences_are_not_called_as_records_of_the_directory() {
        let of = |recording: &str| OwnRecordingArgs {
            recordings: vec![recording.into()],
            labels: vec!["labels.csv".into()],
            out: "out".into(),
            start_us: 0,
            max_gap_ms: 100,
        };
        assert!(of("jump.raw").pairs().is_ok());
        let message = of("run.raw").pairs().map(|_| ()).unwrap_err().to_string();
        assert!(message.contains("`run.toml` is a record"), "{message}");
    }
}
