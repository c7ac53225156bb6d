//! `evpose check-labels`: detection of implausible body labels.

mod args;
mod images;
mod source;

use std::process::ExitCode;

use anyhow::{Result, bail};
use evpose_datasets::check::check_labels;

pub use args::CheckLabelsArgs;

use crate::json::write_json;
use crate::progress::say;

/// Exit code with findings.
const HAS_FINDINGS: u8 = 2;

/// Runs `evpose check-labels`.
pub fn run(args: &CheckLabelsArgs) -> Result<ExitCode> {
    let mut sources = Vec::new();
    for path in &args.paths {
        let labels = source::find(path)?;
        if labels.is_empty() {
            bail!(
                "{}: no labels: expected annotations (.json), poses (.poses.csv) or folders of skeletons \
                 with a data.log",
                path.display()
            );
        }
        sources.extend(labels);
    }
    // All tracks first: which bones are outliers depends on those of the others.
    let mut tracks = Vec::new();
    for source in &sources {
        tracks.extend(source.tracks(args.image_size, args.transposed)?);
    }
    let report = check_labels(&tracks, &args.thresholds.options());
    write_json(args.json.as_deref(), &report)?;
    say(report.to_string().trim_end());
    Ok(if report.findings.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(HAS_FINDINGS) })
}
