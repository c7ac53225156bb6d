//! Arguments of `evpose view`.

use std::path::PathBuf;

use crate::commands::opening::RecordingArgs;
use crate::outputs::OutputFile;
use crate::ranges::{milliseconds, seconds, since_start, within};

/// Arguments of `evpose view`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose view rec.aedat4 --out view.html\n  \
    evpose view rec.raw --of lnes --window-ms 100 --from 2 --to 3 --out sheet.png\n  \
    evpose view rec.npz --of eros --frames 200 --out eros.apng\n  \
    evpose view people/0000.raw --joints joints.csv --truth people/0000.poses.csv --out people.html\n  \
    evpose view rec.aedat4 --frames 60 --fps 15 --out rec.gif\n  \
    evpose view rec.npz --out rec.rrd\n  \
    evpose view rec.npz --rerun=192.168.0.7:9876\n\n\
    The page has a slider and an animation, and needs no other file. ON events are blue, OFF events red, true joints \
    green, predicted joints orange.")]
pub struct ViewArgs {
    #[command(flatten)]
    pub(crate) recording: RecordingArgs,
    /// Where to write: .html (a page with a slider), .png (a sheet), .apng or .gif (an animation), or
    /// .rrd (for the Rerun viewer; feature `rerun`)
    #[arg(long, required_unless_present = "rerun", conflicts_with = "rerun")]
    pub(crate) out: Option<OutputFile>,
    /// Send the recording to a running Rerun viewer, by default on this machine (feature `rerun`)
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, require_equals = true)]
    pub(crate) rerun: Option<Option<String>>,
    /// Content: `events`, or a representation such as lnes or eros
    #[arg(long, default_value = "events")]
    pub(crate) of: String,
    /// Time window of a frame, in milliseconds
    #[arg(long, default_value_t = 33.0, value_parser = milliseconds())]
    pub(crate) window_ms: f64,
    /// Number of frames, evenly spaced [default: 12 on a sheet, 300 in Rerun, 100 otherwise]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=2000))]
    pub(crate) frames: Option<u32>,
    /// Begin so many seconds after the first event
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = since_start())]
    pub(crate) from: f64,
    /// End so many seconds after the first event [default: the end of the recording]
    #[arg(long, value_name = "SECONDS", value_parser = seconds())]
    pub(crate) to: Option<f64>,
    /// Overlay predicted joints in orange: poses of `evpose infer` or `evpose live`, in any format
    #[arg(long, value_name = "FILE")]
    pub(crate) joints: Option<PathBuf>,
    /// Overlay true joints in green: labels of `evpose simulate`, `.meta` or a table of poses
    #[arg(long, value_name = "FILE")]
    pub(crate) truth: Option<PathBuf>,
    /// Frames per second of the animation
    #[arg(long, default_value_t = 20.0, value_parser = within(1e-3..=1000.0))]
    pub(crate) fps: f64,
}
