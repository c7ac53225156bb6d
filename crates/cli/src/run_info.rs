//! Provenance beside the results of an output directory: resolved config, seed, commit.

use std::path::Path;

use anyhow::{Context, Result, bail};
use evpose_task::Experiment;
use evpose_task::hand::HandConfig;
use evpose_train::TrainError;

use crate::outputs::write_file;

/// File of the program, the seed and, mostly, the command.
const RUN: &str = "run.toml";
/// File of the resolved config.
pub const CONFIG: &str = "config.toml";

/// The commit this binary was built from.
pub const COMMIT: &str = env!("EVPOSE_COMMIT");

/// Seed, commit and version.
fn origin(seed: u64) -> Result<toml::Table> {
    let mut run = toml::Table::new();
    run.insert("seed".into(), i64::try_from(seed).context("a seed must fit 63 bits")?.into());
    run.insert("commit".into(), COMMIT.into());
    run.insert("version".into(), env!("CARGO_PKG_VERSION").into());
    Ok(run)
}

/// Command, seed, commit and version.
pub fn table(seed: u64) -> Result<toml::Table> {
    let mut run = origin(seed)?;
    let command = std::env::args().collect::<Vec<_>>().join(" ");
    run.insert("command".into(), command.into());
    Ok(run)
}

/// Writes `run.toml` (command, seed, commit, version) and, where given, `config.toml`.
pub fn write(dir: &Path, seed: u64, config: Option<&HandConfig>) -> Result<()> {
    write_file(&dir.join(RUN), table(seed)?.to_string())?;
    match config {
        Some(config) => write_file(&dir.join(CONFIG), config.to_toml()?),
        None => Ok(()),
    }
}

/// Writes `run.toml` without the command, for a directory of several processes, and refuses that of
/// another build of the program or another seed.
///
/// # Errors
/// If the file is of another build, or cannot be read or written.
pub fn claim_origin(dir: &Path, seed: u64) -> Result<()> {
    if !dir.join(RUN).exists() {
        write_file(&dir.join(RUN), origin(seed)?.to_string())?;
    }
    check_origin(dir, seed)
}

/// As [`write()`], for a directory that several processes share: without the command, which differs
/// between them. `config.toml` is written last, so that its existence implies that of `run.toml`.
pub fn write_shared(dir: &Path, config: &impl Experiment) -> Result<()> {
    write_file(&dir.join(RUN), origin(config.seed())?.to_string())?;
    write_file(&dir.join(CONFIG), config.to_toml()?)
}

/// Refuses a directory of another config, or of another build of the program, whose random draws
/// may differ.
pub fn check_shared<C: Experiment>(dir: &Path, config: &C) -> Result<()> {
    let path = dir.join(CONFIG);
    let fields = config.differences(&C::read(&path)?)?;
    if !fields.is_empty() {
        return Err(TrainError::ConfigDiffers { path, fields }.into());
    }
    check_origin(dir, config.seed())
}

fn check_origin(dir: &Path, seed: u64) -> Result<()> {
    let path = dir.join(RUN);
    let text =
        std::fs::read_to_string(&path).with_context(|| format!("reading {}", path.display()))?;
    let there: toml::Table =
        toml::from_str(&text).with_context(|| format!("reading {}", path.display()))?;
    // The commit counts as well: another build may draw other random values.
    for (key, here) in origin(seed)? {
        if there.get(&key) != Some(&here) {
            bail!(
                "{}: the directory was begun by another program ({key} is {}, and this one's is \
                 {here}): finish it with the same one, or choose another --out",
                path.display(),
                there.get(&key).map_or_else(|| "absent".to_owned(), ToString::to_string)
            );
        }
    }
    Ok(())
}
