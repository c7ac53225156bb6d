//! `evpose check-labels`: labels of bodies that are wrong, or look as if they were.

mod args;
mod images;
mod source;

use std::process::ExitCode;

use anyhow::{Result, bail};
use evpose_datasets::check::check_labels;

pub(crate) use args::CheckLabelsArgs;

use evpose_app::json::write_json;
use evpose_app::progress::say;

/// How the command ends where something is found.
const FOUND: u8 = 2;

pub(crate) fn run(args: &CheckLabelsArgs) -> Result<ExitCode> {
    let mut sources = Vec::new();
    for path in &args.paths {
        let found = source::find(path)?;
        if found.is_empty() {
            bail!(
                "{}: no labels are here: annotations (.json), poses (.poses.csv) or folders of \
                 skeletons with a data.log are expected",
                path.display()
            );
        }
        sources.extend(found);
    }
    let mut tracks = Vec::new();
    for source in &sources {
        tracks.extend(source.tracks(args.image_size, args.transposed)?);
    }
    let report = check_labels(&tracks, &args.thresholds.options());
    write_json(args.json.as_deref(), &report)?;
    say(report.to_string().trim_end());
    Ok(if report.findings.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(FOUND) })
}
