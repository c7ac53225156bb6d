//! `evpose bench accuracy`: the accuracy of networks on named sets, one stored file a set.

mod digest;
mod record;
mod sets;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use evpose_cli::json::write_result;
use evpose_cli::progress::say;
use evpose_cli::provenance::Provenance;
use evpose_cli::shipped::checkpoint_path;
use evpose_cli::tasks::args::EvalArgs;
use evpose_cli::threads::use_threads;

use evpose_cli::ranges::threads;
use record::{NetworkRecord, Record};
use sets::{Prepared, SetName, parsed};

/// Why the foreign set is not evaluated on.
const CLOSED: &str = "the foreign set is opened once per release, by whoever makes it: --open-foreign; for all else \
     there is the development set";

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose bench accuracy\n  \
    evpose bench accuracy --set real --real dhp19_eros\n  \
    evpose bench accuracy --set foreign --open-foreign          # once per release\n\n\
    Writes home.json, development.json and real.json anew, with every metric, the values of each recording, and the \
    digests of the set and of the networks. What it says of the foreign set it writes to a file of its own, and only \
    once for a version of the program.")]
pub struct BenchAccuracyArgs {
    /// Sets to evaluate on
    #[arg(long = "set", value_name = "SET", value_delimiter = ',', default_values = ["home", "development"])]
    pub(crate) sets: Vec<SetName>,
    /// Run directories, .bpk files, or names of shipped networks
    #[arg(long, value_name = "NETWORK", value_delimiter = ',',
          default_values = ["body", "body-quick", "hand", "hand-quick"])]
    pub(crate) checkpoint: Vec<PathBuf>,
    /// The development set: recordings of other simulators that networks were tuned by
    #[arg(long, value_name = "DIR", default_value = "datasets/development")]
    pub(crate) development: PathBuf,
    /// Real images with joints: a folder of clips, each with `poses.json` and `images`
    #[arg(long, value_name = "DIR")]
    pub(crate) real: Option<PathBuf>,
    /// The foreign set, which nothing is tuned by
    #[arg(long, value_name = "DIR", default_value = "datasets/foreign")]
    pub(crate) foreign: PathBuf,
    /// Evaluate on the foreign set, which is done once per release
    #[arg(long)]
    pub(crate) open_foreign: bool,
    /// Where to write the results
    #[arg(long, value_name = "DIR", default_value = "benches/accuracy")]
    pub(crate) out: PathBuf,
    /// CPU threads; all cores by default
    #[arg(long, value_parser = threads())]
    pub(crate) threads: Option<usize>,
}

/// Evaluates every network on every set.
///
/// # Errors
/// If a set is missing, the foreign one was opened before or is not to be opened, or a result cannot be
/// written.
pub(super) fn run(args: &BenchAccuracyArgs) -> Result<()> {
    use_threads(args.threads)?;
    for set in &args.sets {
        let provenance = Provenance::this();
        let scratch = tempfile::tempdir().context("a directory for recordings")?;
        let prepared = set.prepare(args, scratch.path())?;
        // This precedes any evaluation: a foreign set that was opened must yield no further scores.
        let path = match set {
            SetName::Foreign => foreign_path(args, &provenance.version, &prepared.digest)?,
            set => args.out.join(format!("{}.json", set.word())),
        };
        let mut networks = Vec::new();
        for checkpoint in &args.checkpoint {
            networks.extend(evaluated(checkpoint, &prepared, scratch.path())?);
        }
        let Prepared { digest, simulated, .. } = prepared;
        let record = Record { provenance, set: set.word(), digest, simulated, networks };
        std::fs::create_dir_all(&args.out).with_context(|| args.out.display().to_string())?;
        write_result(&path, &record)?;
        say(format!("stored    {}", path.display()));
    }
    Ok(())
}

/// The file of what a version of the program says of the foreign set.
///
/// # Errors
/// If the version has opened the set before.
fn foreign_path(args: &BenchAccuracyArgs, version: &str, digest: &str) -> Result<PathBuf> {
    let path = args.out.join(format!("foreign-{version}-{}.json", &digest[..12]));
    if path.exists() {
        bail!("{}: version {version} has opened this foreign set", path.display());
    }
    Ok(path)
}

/// The result of a network on the recordings of its task, if the set has some.
fn evaluated(checkpoint: &Path, set: &Prepared, scratch: &Path) -> Result<Option<NetworkRecord>> {
    let path = checkpoint_path(checkpoint)?;
    let name = checkpoint.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    // Always the CPU: GPUs differ in the last bits from device to device.
    let device =
        evpose_cli::args::DeviceArgs { device: evpose_nn::DeviceKind::Flex, threads: None };
    let model = evpose_cli::tasks::open(&path, &device)?;
    let Some(words) = set.evaluation(model.task()) else { return Ok(None) };
    say(format!("\n== {name}: {}", words.join(" ")));
    let json = scratch.join("result.json");
    let json_word = json.to_string_lossy();
    let path_word = path.to_string_lossy();
    let own = ["--checkpoint", &path_word, "--json", &json_word];
    // The command's own parser reads them, so that the stored line reproduces the result.
    let arguments: EvalArgs = parsed(words.iter().map(String::as_str).chain(own))?;
    model.evaluate(&arguments)?;
    let text = std::fs::read_to_string(&json).context("reading the result")?;
    Ok(Some(NetworkRecord {
        sha256: digest::of_path(&path)?,
        task: model.task(),
        name,
        evaluation: Prepared::shown(&words),
        result: serde_json::from_str(&text).context("reading the result")?,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_foreign_set_is_opened_once_per_version() {
        let folder = tempfile::tempdir().unwrap();
        let digest = "0123456789abcdef";
        let args: BenchAccuracyArgs = parsed(["--out", folder.path().to_str().unwrap()]).unwrap();
        let message = SetName::Foreign.prepare(&args, folder.path()).err().unwrap().to_string();
        assert!(message.contains("--open-foreign"), "{message}");
        let path = foreign_path(&args, "0.1.0", digest).unwrap();
        std::fs::write(&path, "{}").unwrap();
        let message = foreign_path(&args, "0.1.0", digest).unwrap_err().to_string();
        assert!(message.contains("has opened"), "{message}");
        // Another release, and another set.
        foreign_path(&args, "0.2.0", digest).unwrap();
        foreign_path(&args, "0.1.0", "f123456789abcdef").unwrap();
    }
}
