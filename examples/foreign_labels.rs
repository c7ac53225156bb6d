//! Exports simulated recordings as somebody else's program would deliver them, to try the import of
//! a user's own labels: events as `.npz`, joints as COCO's JSON and as CSV.
//!
//! ```console
//! $ cargo run --release --example foreign_labels [DIRECTORY OUT]
//! ```
//!
//! DIRECTORY is one of `evpose simulate`. Without it, a person is simulated first.

#![allow(clippy::print_stdout, reason = "a program")]

#[path = "../tests/integration/own_labels/foreign.rs"]
mod foreign;

use std::path::{Path, PathBuf};

use anyhow::Result;
use evpose_core::SensorSize;
use evpose_sim::Shard;
use evpose_sim::person::{People, PeopleConfig, record_people};

fn main() -> Result<()> {
    let temporary = tempfile::tempdir()?;
    let mut arguments = std::env::args().skip(1).map(PathBuf::from);
    let (directory, out) = match (arguments.next(), arguments.next()) {
        (Some(directory), Some(out)) => (directory, out),
        _ => (simulated(temporary.path())?, temporary.path().join("foreign")),
    };
    let count = foreign::export(&directory, &out)?;
    println!("{count} recordings of {} exported", directory.display());
    let mut names: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(&out)? {
        names.push(entry?.file_name().into());
    }
    names.sort();
    names.iter().for_each(|name| println!("  {}", name.display()));
    Ok(())
}

/// A directory with a short recording of a person.
fn simulated(folder: &Path) -> Result<PathBuf> {
    let directory = folder.join("simulated");
    let config = PeopleConfig {
        sequences: 1,
        seconds: 0.2,
        sensor_size: SensorSize { width: 96, height: 72 },
        ..PeopleConfig::default()
    };
    record_people(&People::new(&config, 1)?, &directory, Shard::WHOLE, &|_| {})?;
    Ok(directory)
}
