//! The common part of studies: they claim a directory, count seeds, average over them, and write
//! results.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use burn::tensor::Device;
use evpose_cli::args::{ConfigArgs, DeviceArgs};
use evpose_cli::json::write_result;
use evpose_cli::machine::Machine;
use evpose_cli::progress::say;
use evpose_core::{atomic_write, temporary_target};
use evpose_report::chart::{self, Series};
use evpose_report::colour::PALETTE;
use serde::Serialize;

/// How a verdict follows from an interval, for legends.
pub(crate) const VERDICTS: &str = "found where all of it agrees with what was published, reversed \
    where all of it contradicts, else within noise";

/// Arguments of every study.
#[derive(Debug, clap::Args)]
pub struct StudyArgs {
    /// Change one field of all trainings, for example --set training.steps=500 (may be repeated)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// Directory for data, trainings, tables and the page
    #[arg(long)]
    pub out: PathBuf,
    /// Keep what an interrupted study in the directory finished, and go on, or add to it
    #[arg(long)]
    pub resume: bool,
    /// Device and threads.
    #[command(flatten)]
    pub device: DeviceArgs,
}

impl StudyArgs {
    /// Opens the device: one that is missing is an error before anything is simulated.
    pub(crate) fn open(&self) -> Result<Device> {
        evpose_kernels::keep_freed_memory();
        self.device.open()
    }

    /// A config with the changes of `--set`.
    pub(crate) fn config(&self, config: &str) -> ConfigArgs {
        ConfigArgs { config: config.to_owned(), overrides: self.overrides.clone() }
    }

    /// Prints where the study runs, and where its results will be.
    pub(crate) fn say_place(&self) {
        say(format!("machine: {}", Machine::this()));
        say(format!("output:  {}", self.out.display()));
    }
}

/// How often a study is repeated.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct SeedArgs {
    /// Number of seeds, from that of the config on: intervals are over seeds
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=100))]
    pub seeds: u64,
}

impl SeedArgs {
    /// As many seeds, from the first on.
    pub(crate) fn all(self, first: u64) -> Result<Vec<u64>> {
        let seeds: Option<Vec<u64>> = (0..self.seeds).map(|i| first.checked_add(i)).collect();
        seeds.context("config field `seed`: too large to count on from")
    }
}

/// Whether a directory holds files. Those of a study that was begun are kept if it resumes.
///
/// # Errors
/// If there are files, and the study does not resume.
pub(crate) fn is_begun(out: &Path, resume: bool) -> Result<bool> {
    let is_begun = out.read_dir().is_ok_and(|mut entries| entries.next().is_some());
    if is_begun && !resume {
        bail!("{} is not empty: add --resume, or choose another --out", out.display());
    }
    Ok(is_begun)
}

/// Whether anything in a directory is neither of the `names` nor a temporary file of one: a study that was killed
/// as it began, or that begins at this moment in another process, holds no others.
pub(crate) fn holds_others(out: &Path, names: &[&str]) -> bool {
    let entries = out.read_dir().into_iter().flatten().flatten();
    entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).any(|name| {
        let name = temporary_target(&name).unwrap_or(&name);
        !names.contains(&name)
    })
}

/// Writes an input of a study where it is absent. Another process may do the same at once.
///
/// # Errors
/// If the file holds another text, or cannot be read or written.
pub(crate) fn claim(path: &Path, text: &str) -> Result<()> {
    if !path.exists() {
        write(path, text)?;
    }
    let there =
        std::fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))?;
    if there != text {
        bail!("{} differs from what is given: give the same, or another --out", path.display());
    }
    Ok(())
}

/// Writes a file, atomically, and the directory that it is in.
pub(crate) fn write(path: &Path, text: &str) -> Result<()> {
    if let Some(parent) = path.parent() {
        std::fs::create_dir_all(parent)
            .with_context(|| format!("creating {}", parent.display()))?;
    }
    atomic_write(path, text.as_bytes()).with_context(|| format!("writing {}", path.display()))
}

/// Seeds as text: `1, 2, 3`.
pub(crate) fn listed(seeds: &[u64]) -> String {
    seeds.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")
}

/// The mean of curves of several seeds, point by point.
pub(crate) fn mean_curve<'a>(curves: impl Iterator<Item = &'a [f64]>) -> Vec<f64> {
    let curves: Vec<&[f64]> = curves.collect();
    let points = curves.iter().map(|curve| curve.len()).min().unwrap_or(0);
    let at = |i: usize| curves.iter().map(|curve| curve[i]).sum::<f64>() / curves.len() as f64;
    (0..points).map(at).collect()
}

/// Shares of correct joints at 1 %, 2 %, … of the diagonal of the torso, one curve a name.
pub(crate) fn pck_chart<'a>(curves: impl Iterator<Item = (&'a str, &'a [f64])>) -> Result<String> {
    let curves = curves.zip(PALETTE).map(|((name, curve), colour)| {
        let points = (1..).zip(curve).map(|(percent, y)| (f64::from(percent) / 100.0, *y));
        Series::line(name, colour, points.collect())
    });
    Ok(chart::pck("PCK", "threshold, diagonals of the torso", curves.collect())?)
}

/// A table as Markdown.
pub(crate) fn markdown_table<R: AsRef<[String]>>(
    header: &[&str],
    rows: impl Iterator<Item = R>,
) -> String {
    let head = format!("| {} |\n|{}\n", header.join(" | "), "---|".repeat(header.len()));
    rows.fold(head, |text, row| text + &format!("| {} |\n", row.as_ref().join(" | ")))
}

/// The results of a study: values, table, page.
pub(crate) struct ResultFiles(pub(crate) [PathBuf; 3]);

impl ResultFiles {
    /// `NAME.json`, `NAME.md` and `NAME.html` in a directory.
    pub(crate) fn new(out: &Path, name: &str) -> Self {
        Self(["json", "md", "html"].map(|kind| out.join(format!("{name}.{kind}"))))
    }

    /// Writes all of them.
    pub(crate) fn write(&self, values: &impl Serialize, table: &str, page: &str) -> Result<()> {
        let Self([json, markdown, html]) = self;
        write_result(json, values)?;
        write(markdown, table)?;
        write(html, page)
    }

    /// Prints the time that the study took, and where its results are.
    pub(crate) fn say_written(&self, started: Instant) {
        say(format!("done in {:.1} minutes", started.elapsed().as_secs_f64() / 60.0));
        for path in &self.0 {
            say(format!("written: {}", path.display()));
        }
    }
}
