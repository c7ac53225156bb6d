//! `evpose view`: a recording to look at.

mod args;
mod files;
mod page;
mod picture;
mod shots;

use std::path::Path;

use anyhow::{Result, bail};
use evpose_core::atomic_write;

pub(crate) use args::ViewArgs;
use shots::Shots;

use crate::progress::say;

/// A kind of file that pictures go into.
struct Target {
    ending: &'static str,
    /// Pictures, unless the user says.
    pictures: u32,
    make: fn(&Shots, &ViewArgs) -> Result<Vec<u8>>,
}

const TARGETS: [Target; 3] = [
    Target { ending: "html", pictures: 100, make: page::page },
    Target { ending: "png", pictures: 12, make: |shots, _| files::sheet(shots) },
    Target { ending: "apng", pictures: 100, make: |shots, args| files::animation(shots, args.fps) },
];

pub(crate) fn run(args: &ViewArgs) -> Result<()> {
    let target = target(&args.out)?;
    if !(args.fps > 0.0 && args.fps <= 1000.0) {
        bail!("--fps {}: expected 0 to 1000 pictures a second", args.fps);
    }
    let shots = Shots::take(args, args.pictures.unwrap_or(target.pictures))?;
    for warning in &shots.warnings {
        say(format!("warning   {warning}"));
    }
    atomic_write(&args.out, &(target.make)(&shots, args)?)?;
    say(format!("{}: {} of {}", args.out.display(), shots.summary(), shots.name));
    Ok(())
}

fn target(out: &Path) -> Result<&'static Target> {
    let ending = out.extension().unwrap_or_default();
    match TARGETS.iter().find(|target| ending == target.ending) {
        Some(target) => Ok(target),
        None => bail!("{}: the name should end in .html, .png or .apng", out.display()),
    }
}
