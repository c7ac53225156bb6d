//! `evpose clean`: checks and preprocesses a recording.

mod args;
mod orientation;
pub(super) mod passes;

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use evpose_clean::{Checkup, CleanerChain};
use evpose_core::EventStream;

pub use args::CleanArgs;
use passes::Passes;

use super::convert::format;
use crate::progress::say;

/// Runs `evpose clean`.
pub fn run(args: &CleanArgs) -> Result<()> {
    let options = args.recording.opening.options(&args.recording.input)?;
    // Errors of the target are reported before the recording is read, which may take long.
    let target = match &args.out {
        Some(out) => Some((&**out, format(out, args.format.as_deref())?)),
        None => None,
    };
    let (passes, account) = Passes::open(&args.recording.input, options)?;
    account.print();
    check(&passes, Checkup::new(account.sensor))?;
    let symmetry = match &args.reference {
        Some(reference) => orientation::find(&passes, account.sensor, reference)?,
        None => None,
    };
    let Some((out, format)) = target else { return Ok(()) };
    // Where axes are swapped, so are width and height.
    let sensor = symmetry.map_or(account.sensor, |symmetry| symmetry.size(account.sensor));
    let transform = |events: &mut EventStream| {
        if let Some(symmetry) = symmetry {
            *events = symmetry.apply(events);
        }
    };
    let mut chain = CleanerChain::new(sensor, &args.cleaners)?;
    // A cleaner surveys what those before it leave, so that each needs a pass of its own.
    while chain.surveys() > 0 {
        passes.read("surveying", |events| {
            transform(events);
            Ok(chain.survey(events)?)
        })?;
        chain.end_survey()?;
    }
    let mut sink = format.create(out, sensor)?;
    let mut written = 0;
    passes.read("cleaning", |events| {
        transform(events);
        chain.clean(events)?;
        written += events.len();
        Ok(sink.write(events)?)
    })?;
    // Cleaners may hold the last events back until they know that no more follow.
    let rest = chain.finish()?;
    sink.write(&rest)?;
    sink.finish()?;
    report(&chain);
    if let Some(folder) = &args.masks {
        write_masks(&chain, folder)?;
    }
    let (path, events) = (out.display(), written + rest.len());
    say(format!("{path}: {events} events of a {sensor} sensor, as {}", format.name));
    Ok(())
}

/// Prints a summary of the events, and anomalies.
fn check(passes: &Passes, mut checkup: Checkup) -> Result<()> {
    passes.read("checking", |events| {
        checkup.push(events);
        Ok(())
    })?;
    let findings = checkup.findings();
    let mut line = format!("check     {} events", findings.events);
    if let Some(share) = findings.on_share {
        line += &format!(", {:.1} % ON", 100.0 * share);
    }
    if let (Some((left, right)), Some((top, bottom))) = (findings.columns, findings.rows) {
        line += &format!(", columns {left} to {right}, rows {top} to {bottom}");
    }
    say(line);
    for remark in findings.remarks {
        say(format!("warning   {remark}"));
    }
    Ok(())
}

/// Prints the removed events of each cleaner.
fn report(chain: &CleanerChain) {
    for report in chain.report() {
        let removed = report.removed();
        let share = 100.0 * removed as f64 / report.entered.max(1) as f64;
        let mut line = format!(
            "{:9} removed {removed} of {} events ({share:.2} %)",
            report.cleaner, report.entered
        );
        for note in report.notes {
            line += &format!(", {} {}", note.count, note.what);
        }
        say(line);
    }
}

/// Writes the masks into a folder, numbered in the order of the chain.
fn write_masks(chain: &CleanerChain, folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
    for (place, (name, mask)) in chain.masks().enumerate() {
        let path = folder.join(format!("{}-{name}.toml", place + 1));
        mask.save(&path)?;
        say(format!("mask      {}", path.display()));
    }
    Ok(())
}
