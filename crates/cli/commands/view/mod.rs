//! `evpose view`: a recording to look at.

mod args;
mod caption;
mod files;
mod overlay;
mod page;
mod picture;
mod rerun;
mod shots;

use std::path::Path;

use anyhow::{Result, bail};
use evpose_core::atomic_write;

pub(crate) use args::ViewArgs;
use shots::{Reel, Shots};

use evpose_app::progress::say;

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
    if !(args.fps > 0.0 && args.fps <= 1000.0) {
        bail!("--fps {}: expected 0 to 1000 pictures a second", args.fps);
    }
    let Some(out) = &args.out else { return rerun::send(args) };
    if out.extension().is_some_and(|ending| ending == rerun::ENDING) {
        return rerun::write(args, out);
    }
    let target = target(out)?;
    let shots = Shots::take(Reel::open(args, args.pictures.unwrap_or(target.pictures))?)?;
    atomic_write(out, &(target.make)(&shots, args)?)?;
    report(&shots.reel, &out.display().to_string());
    Ok(())
}

fn target(out: &Path) -> Result<&'static Target> {
    let ending = out.extension().unwrap_or_default();
    match TARGETS.iter().find(|target| ending == target.ending) {
        Some(target) => Ok(target),
        None => bail!("{}: the name should end in .html, .png, .apng or .rrd", out.display()),
    }
}

/// What was shown, and where.
fn report(reel: &Reel, place: &str) {
    for warning in reel.warnings() {
        say(format!("warning   {warning}"));
    }
    say(format!("{place}: {} of {}", reel.summary(), reel.name));
}
