//! `evpose bench io`: how fast recordings come from the page cache, on one core.

mod evc;
mod formats;
#[cfg(feature = "peers")]
mod rivals;

use anyhow::{Context, Result};
use serde::Serialize;

use crate::all::Figure;
use crate::peer_bench::{Case, CaseResult, is_named, matching, run_peers, time, warn_under_load};
use crate::peer_bench::{PEERS, PeerCommand};
use evpose_cli::json::write_json;
use evpose_cli::machine::Machine;
use evpose_cli::outputs::OutputFile;
use evpose_cli::progress::say;
use evpose_cli::provenance::Provenance;
use evpose_cli::ranges::{count, within};
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
#[command(after_help = format!("Examples:\n  evpose bench io\n  evpose bench io --only aedat4 --json io.json\n  \
    evpose bench io --file rec.raw --peer 'dv=python3 peer.py'\n\n{PEERS}\n\n\
    Build with --features peers to time other decoders of EVT 3.0 in the same run."))]
pub struct BenchIoArgs {
    /// Frames of 1 ms in the file that is made for it
    #[arg(long, default_value_t = 250_000, value_parser = within(1..=1_000_000_000_u64))]
    pub(crate) frames: u64,
    /// Events in each, on average
    #[arg(long, default_value_t = 200, value_parser = count::<u32>())]
    pub(crate) events_per_frame: u32,
    /// Times each reader reads it all
    #[arg(long, default_value_t = 15, value_parser = count::<usize>())]
    pub(crate) passes: usize,
    /// Events in each file of the other formats
    #[arg(long, default_value_t = 2_000_000, value_parser = within(1..=1_000_000_000_usize))]
    pub(crate) events: usize,
    /// Only cases with this in their name; given twice, with both
    #[arg(long, value_name = "WORD")]
    pub(crate) only: Vec<String>,
    /// A recording of yours to read as well (may be repeated)
    #[arg(long = "file", value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Another program on the same files, in the same run (may be repeated)
    #[arg(long = "peer", value_name = "NAME=COMMAND")]
    pub(crate) peers: Vec<PeerCommand>,
    /// Folder for the files [default: the system's for temporary files]
    #[arg(long)]
    pub(crate) scratch: Option<PathBuf>,
    /// Where to write the results as JSON
    #[arg(long)]
    pub(crate) json: Option<OutputFile>,
}

/// Content of the JSON file.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    provenance: Provenance,
    frames: u64,
    cases: Vec<CaseResult>,
}

pub(crate) fn run(args: &BenchIoArgs) -> Result<()> {
    write_json(args.json.as_deref(), &measure(args)?)
}

pub(crate) fn figures(args: &BenchIoArgs) -> Result<Vec<Figure>> {
    Ok(measure(args)?.cases.iter().map(|case| case.figure("io")).collect())
}

fn measure(args: &BenchIoArgs) -> Result<Report> {
    let scratch = match &args.scratch {
        Some(folder) => tempfile::tempdir_in(folder),
        None => tempfile::tempdir(),
    }
    .context("making a folder for the files")?;
    // One thread, whatever the machine has: files are read on one core.
    let provenance = Provenance::new(Machine { threads: 1, ..Machine::this() });
    say(format!("machine   {}", provenance.machine));
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
    let mut lines = time(matching(cases, &args.only)?, args.passes)?;
    for line in lines.iter().filter(|line| line.is_of(evc::NAMES[0])) {
        let frames = line.passes_per_second() * args.frames as f64 / 1e6;
        say(format!("that is {frames:.2} M frames/s of evc into reused records"));
    }
    run_peers(&args.peers, scratch.path(), &mut lines)?;
    warn_under_load(&lines);
    let report = Report { provenance, frames: args.frames, cases: lines };
    Ok(report)
}
