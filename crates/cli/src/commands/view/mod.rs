//! `evpose view`: renders a recording.

mod args;
mod caption;
mod files;
mod frames;
mod key;
mod overlay;
mod page;
mod palette;
mod rerun;

use std::path::Path;

use anyhow::{Context, Result};
use evpose_core::atomic_write;

pub use args::ViewArgs;
pub(super) use palette::Palette;

use frames::{FrameReader, RenderedFrames};

use crate::progress::say;

/// An output format.
struct Target {
    ending: &'static str,
    /// Default number of frames.
    frames: u32,
    make: fn(&RenderedFrames, &ViewArgs) -> Result<Vec<u8>>,
}

const TARGETS: [Target; 4] = [
    Target { ending: "html", frames: 100, make: page::page },
    Target { ending: "png", frames: 12, make: |frames, _| files::sheet(frames) },
    Target { ending: "apng", frames: 100, make: |frames, args| files::animation(frames, args.fps) },
    Target { ending: "gif", frames: 100, make: |frames, args| files::gif(frames, args.fps) },
];

/// Runs `evpose view`.
pub fn run(args: &ViewArgs) -> Result<()> {
    let Some(out) = &args.out else { return rerun::send(args) };
    if out.extension().is_some_and(|ending| ending == rerun::ENDING) {
        return rerun::write(args, out);
    }
    let target = target(out)?;
    let frames =
        RenderedFrames::take(FrameReader::open(args, args.frames.unwrap_or(target.frames))?)?;
    atomic_write(out, &(target.make)(&frames, args)?)?;
    report(&frames.reader, &out.display().to_string());
    Ok(())
}

fn target(out: &Path) -> Result<&'static Target> {
    let ending = out.extension().unwrap_or_default();
    TARGETS.iter().find(|target| ending == target.ending).with_context(|| {
        format!("{}: the name should end in .html, .png, .apng, .gif or .rrd", out.display())
    })
}

/// Prints a summary and warnings.
fn report(reader: &FrameReader, place: &str) {
    for warning in reader.warnings() {
        say(format!("warning   {warning}"));
    }
    say(format!("{place}: {} of {}", reader.summary(), reader.name));
}
