//! `evpose gap camera`: a camera from recordings whose light is not known.

use anyhow::{Context, Result};
use evpose_gap::camera::{CameraRecording, CameraReport};
use evpose_gap::input::load_recording;
use serde::Serialize;

use super::args::CameraArgs;
use crate::bad_input::BadInput;
use crate::json::write_result;
use crate::outputs::write_file;
use crate::pages::gap_camera;
use crate::progress::{say, spinner};
use crate::run_info::COMMIT;
use crate::threads::use_threads;

/// Content of the JSON file.
#[derive(Serialize)]
struct Written<'a> {
    version: &'static str,
    commit: &'static str,
    #[serde(flatten)]
    report: &'a CameraReport,
}

pub(super) fn run(args: &CameraArgs) -> Result<()> {
    use_threads(args.threads)?;
    let report = CameraReport::new(load(args).context(BadInput)?).context(BadInput)?;
    let dir = &args.out;
    std::fs::create_dir_all(dir).with_context(|| format!("creating {}", dir.display()))?;
    write_file(&dir.join("camera.toml"), report.preset())?;
    let version = env!("CARGO_PKG_VERSION");
    let written = Written { version, commit: COMMIT, report: &report };
    write_result(&dir.join("camera.json"), &written)?;
    write_file(&dir.join("camera.html"), gap_camera::page(&report)?)?;
    for one in &report.recordings {
        let state = if one.is_at_rest { ", at rest" } else { "" };
        say(format!(
            "read      {}: {} events in {:.2} s{state}",
            one.name,
            one.events.len(),
            one.seconds
        ));
    }
    for [state, name, text, from] in report.rows() {
        say(format!("{state:<9} {name:<17} {text}\n{:28}{from}", ""));
    }
    say(format!("written to {}", dir.display()));
    Ok(())
}

/// Reads and tests all recordings, and prints notes on them.
fn load(args: &CameraArgs) -> Result<Vec<CameraRecording>> {
    // Copies whose times are redrawn take seconds a recording.
    let spinner = spinner();
    let mut recordings = Vec::new();
    for path in &args.recordings {
        spinner.set_message(format!("testing {}", path.display()));
        let read = load_recording(path, None, &args.opening.options(path)?)?;
        for note in &read.notes {
            spinner.suspend(|| say(format!("note      {}: {note}", path.display())));
        }
        recordings.push(CameraRecording::new(path.display().to_string(), read.events)?);
    }
    spinner.finish_and_clear();
    Ok(recordings)
}
