//! Arguments of `evpose represent`.

use std::path::PathBuf;

use std::fmt::Write as _;

use crate::tasks::opening::parse_size;
use evpose_core::SensorSize;
use evpose_repr::REPRESENTATIONS;

use crate::commands::opening::RecordingArgs;
use crate::outputs::OutputFile;
use crate::ranges::{milliseconds, seconds, since_start};

/// Arguments that a network decides.
const NOT_OF_NETWORKS: [&str; 7] = ["of", "each", "window_ms", "size", "denoise", "from", "to"];

/// Arguments of `evpose represent`.
#[derive(Debug, clap::Args)]
#[command(after_help = format!("Examples:\n  \
    evpose represent rec.aedat4 --of lnes --window-ms 100 --every-ms 10 --out frames.npy\n  \
    evpose represent rec.raw --of voxel-grid:bins=9 --size 320x180 --out voxels.npz\n  \
    evpose represent rec.npz --of eros:kernel=9 --every-ms 5 --denoise --out eros/\n  \
    evpose represent rec.h5 --of event-count --from 2 --to 3 --each --out windows/\n  \
    evpose represent rec.raw --checkpoint hand --every-ms 10 --out inputs.npz\n\n\
    Arrays are f32, [windows, channels, rows, columns], OFF before ON. A window that ends at t shows the \
    events from t - WINDOW_MS up to, but not including, t.\n\n{}", representations()))]
pub struct RepresentArgs {
    #[command(flatten)]
    pub(crate) recording: RecordingArgs,
    /// Representation: NAME, or NAME:PARAMETER=VALUE,PARAMETER=VALUE
    #[arg(long, value_name = "REPRESENTATION", default_value = "lnes")]
    pub(crate) of: String,
    /// The inputs of this network (a run, a .bpk file, or the name of a shipped one) at the times of `evpose
    /// infer`, in place of a representation: for its exported file
    #[arg(long, value_name = "NETWORK", conflicts_with_all = NOT_OF_NETWORKS)]
    pub(crate) checkpoint: Option<PathBuf>,
    /// Where to write: .npy (one array of all windows), .npz (the array `frames` and `t_us`, the end
    /// of each window) or a directory (a .png per window, and windows.csv)
    #[arg(long)]
    pub(crate) out: OutputFile,
    /// Write a .npy per window into the directory, in place of images
    #[arg(long)]
    pub(crate) each: bool,
    /// Length of a window, in milliseconds; representations with a memory of their own ignore it
    #[arg(long, default_value_t = 33.0, value_parser = milliseconds())]
    pub(crate) window_ms: f64,
    /// From one window to the next, in milliseconds [default: the length of a window; with --checkpoint
    /// that of `evpose infer`]
    #[arg(long, value_parser = milliseconds())]
    pub(crate) every_ms: Option<f64>,
    /// Pool events to this size, at most that of the sensor
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<SensorSize>,
    /// Leave out events that fewer than two neighbouring pixels confirm within so many milliseconds
    /// (20 without a value)
    #[arg(long, value_name = "MILLISECONDS", num_args = 0..=1, require_equals = true,
        default_missing_value = "20", value_parser = milliseconds())]
    pub(crate) denoise: Option<f64>,
    /// Begin so many seconds after the first event
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = since_start())]
    pub(crate) from: f64,
    /// End so many seconds after the first event [default: the end of the recording]
    #[arg(long, value_name = "SECONDS", value_parser = seconds())]
    pub(crate) to: Option<f64>,
}

/// The representations with their parameters, for the help.
fn representations() -> String {
    let mut text = "Representations:\n".to_owned();
    for spec in REPRESENTATIONS.iter() {
        // Writing to a string does not fail.
        let _ = writeln!(text, "  {:16} {}", spec.name, spec.summary);
        for parameter in spec.parameters {
            let (name, doc) = (parameter.name(), parameter.doc());
            let unit = parameter.as_number().map_or("", |number| number.unit);
            let default = parameter.default().map_or_else(String::new, |value| value.to_string());
            let default = format!("{default} {unit}");
            let _ = writeln!(text, "    {name:14} [{}] {doc}", default.trim());
        }
    }
    text
}
