//! `evpose prepare`: conversion of public data sets, and of recordings of the user's own, to
//! training data.

mod args;
mod dhp19;
mod frames;
mod h36m;
mod hands;
mod own_args;
mod people;
mod stills;

use std::path::Path;

use anyhow::Result;

pub use args::PrepareCommand;

use crate::progress::say;
use evpose_datasets::import::WrittenSequence;

/// Runs `evpose prepare`.
pub fn run(command: &PrepareCommand) -> Result<()> {
    match command {
        PrepareCommand::Mpii(args) => stills::mpii(args),
        PrepareCommand::Lsp(args) => stills::lsp(args),
        PrepareCommand::Coco(args) => stills::coco(args),
        PrepareCommand::Dhp19(args) => dhp19::run(args),
        PrepareCommand::Eh36m(args) => h36m::published(args),
        PrepareCommand::H36m(args) => h36m::original(args),
        PrepareCommand::People(args) => people::run(args),
        PrepareCommand::Hands(args) => hands::run(args),
    }
}

/// Maximum number of printed entries of a list; the report has all of them.
const SHOWN: usize = 10;
/// Name of the report beside the labels.
const REPORT: &str = "conversion.json";

fn list(heading: &str, entries: &[String]) {
    if entries.is_empty() {
        return;
    }
    say(format!("{heading}: {}", entries.len()));
    entries.iter().take(SHOWN).for_each(|entry| say(format!("  {entry}")));
    if entries.len() > SHOWN {
        say(format!("  … and {} more, in {REPORT}", entries.len() - SHOWN));
    }
}

/// Prints the command that trains on the prepared data.
fn say_next(config: &str, out: &Path) {
    let out = out.display();
    say(format!("next: evpose train {config} --set data.source=annotations --data {out}"));
}

fn say_sequences(recording: &str, sequences: &[WrittenSequence]) {
    if sequences.len() > 1 {
        say(format!("{recording}: {} sequences, cut at gaps between labels", sequences.len()));
    }
    let lines = sequences.iter().map(|WrittenSequence { name, start, labels }| {
        format!("{name}: {labels} labels, from {:.3} s of the recording", start.as_seconds())
    });
    lines.for_each(say);
}
