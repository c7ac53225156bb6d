//! `evpose bench io`: how fast recordings come from the page cache, on one core.

mod evc;
mod formats;
#[cfg(feature = "peers")]
mod rivals;

use anyhow::{Context, Result};
use serde::Serialize;

use super::as_json;
use crate::args::BenchIoArgs;
use crate::contest::{Case, Line, chosen, invite, is_named, time, warn_if_busy};
use crate::machine::Machine;
use crate::progress::say;
use crate::run_info::COMMIT;

/// What was measured and where.
#[derive(Debug, Serialize)]
struct Report {
    machine: Machine,
    commit: &'static str,
    frames: u64,
    cases: Vec<Line>,
}

pub(crate) fn run(args: &BenchIoArgs) -> Result<()> {
    let scratch = match &args.scratch {
        Some(folder) => tempfile::tempdir_in(folder),
        None => tempfile::tempdir(),
    }
    .context("making a folder for the files")?;
    let machine = Machine { threads: 1, ..Machine::this() };
    say(format!("machine   {machine}"));
    say(format!(
        "files     in the page cache; .evc of {} frames of 1 ms, others of {} events",
        args.frames, args.events
    ));
    let mut cases: Vec<Case> = Vec::new();
    if evc::NAMES.iter().any(|name| is_named(name, &args.only)) {
        cases.extend(evc::cases(scratch.path(), args.frames, args.events_per_frame)?);
    }
    cases.extend(formats::cases(scratch.path(), args.events)?);
    cases.extend(formats::of_user(&args.files)?);
    let mut lines = time(chosen(cases, &args.only)?, args.passes)?;
    for line in lines.iter().filter(|line| line.is_called(evc::NAMES[0])) {
        let frames = line.passes_per_second() * args.frames as f64 / 1e6;
        say(format!("that is {frames:.2} M frames/s of evc into reused records"));
    }
    invite(&args.peers, scratch.path(), &mut lines)?;
    warn_if_busy(&lines);
    let report = Report { machine, commit: COMMIT, frames: args.frames, cases: lines };
    as_json(args.json.as_deref(), &report)
}
