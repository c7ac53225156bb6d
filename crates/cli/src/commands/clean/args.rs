//! Arguments of `evpose clean`.

use std::fmt::Write as _;
use std::path::PathBuf;

use evpose_clean::{CLEANERS, CleanRequest};

use crate::commands::opening::RecordingArgs;
use crate::outputs::OutputFile;

/// Arguments of `evpose clean`.
#[derive(Debug, clap::Args)]
#[command(after_help = format!("Examples:\n  evpose clean rec.aedat4\n  \
    evpose clean rec.aedat4 clean.npz --with hot --with background:tau_ms=5\n  \
    evpose clean rec.raw straight.raw --with undistort:file=camera.toml\n  \
    evpose clean mirrored.npz right.npz --reference simulated.npz\n\n{}", cleaners()))]
pub struct CleanArgs {
    #[command(flatten)]
    pub(crate) recording: RecordingArgs,
    /// File to write, in the format of its extension or of --format; without it, the recording is
    /// only checked
    pub(crate) out: Option<OutputFile>,
    /// Cleaner to apply, NAME or NAME:KEY=VALUE,KEY=VALUE; may be repeated, applied in order
    #[arg(long = "with", value_name = "CLEANER", requires = "out")]
    pub(crate) cleaners: Vec<CleanRequest>,
    /// Events of the same scene by the same clock, to detect and correct mirrored or swapped axes
    /// and inverted polarity
    #[arg(long, value_name = "FILE")]
    pub(crate) reference: Option<PathBuf>,
    /// Name of the format to write
    #[arg(long, requires = "out")]
    pub(crate) format: Option<String>,
    /// Directory for the masks of the cleaners, as `mask:file=` reads them
    #[arg(long, value_name = "DIR", requires = "out")]
    pub(crate) masks: Option<OutputFile>,
}

/// The cleaners with their parameters, for the help.
fn cleaners() -> String {
    let mut text = "Cleaners:\n".to_owned();
    for spec in &CLEANERS {
        // Writing to a string does not fail.
        let _ = writeln!(text, "  {:12} {}", spec.name, spec.summary);
        for param in spec.params {
            let _ = write!(text, "    {:10} {}", param.name(), param.expected());
            if let Some(default) = param.default() {
                let _ = write!(text, " [{default}]");
            }
            let _ = writeln!(text, ": {}", param.doc());
        }
    }
    text
}
