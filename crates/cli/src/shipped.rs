//! Networks that come with the program, by name.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use evpose_core::{Registry, atomic_write, registry_entry};
use evpose_task::network_file;
use sha2::{Digest as _, Sha256};

/// Their directory.
const CHECKPOINTS: &str = "checkpoints";
/// The environment variable of the data directory.
const DATA: &str = "EVPOSE_DATA";

/// A checkpoint inside the program.
#[derive(Debug)]
pub struct EmbeddedNetwork {
    /// Name on the command line.
    pub name: &'static str,
    /// Contents of the weight file.
    pub bytes: &'static [u8],
    /// The model card in Markdown: data, terms, use, accuracy, limits.
    pub card: &'static str,
}

/// The networks inside the program; its `main` registers them.
pub static NETWORKS: Registry<EmbeddedNetwork> = Registry::new(&[]);

registry_entry!(EmbeddedNetwork, "network");

/// The card of the shipped network whose file has these bytes, as plain text: without comments and
/// notes on sources, which are for the page.
pub fn card_of(bytes: &[u8]) -> Option<String> {
    let network = NETWORKS.iter().find(|network| network.bytes == bytes)?;
    let is_text = |line: &&str| !line.starts_with("<!--") && !line.starts_with("<sub>");
    Some(network.card.lines().filter(is_text).collect::<Vec<_>>().join("\n"))
}

/// The file of a checkpoint. Everything but a plain name is a path. `hand` and the like are files
/// of a directory `checkpoints`: here, above the program, or in the data directory `$EVPOSE_DATA`;
/// otherwise the program writes the network that is embedded in it to the data directory.
///
/// # Errors
/// If there is no data directory, or the network cannot be written to it.
pub fn checkpoint_path(given: &Path) -> Result<PathBuf> {
    let program = env::current_exe().unwrap_or_default();
    let data = env::var_os(DATA).map(PathBuf::from);
    // The working folder comes first, so that a checkout has its own networks.
    let here = std::iter::once(Path::new(""));
    let path = path_below(given, here.chain(program.ancestors().skip(1)).chain(data.as_deref()));
    if path.exists() {
        return Ok(path);
    }
    match NETWORKS.iter().find(|network| Path::new(network.name) == given) {
        Some(network) => unpack(network, &data.or_else(user_data).context(NO_DATA)?),
        None => Ok(path),
    }
}

/// SHA-256 of the file that [`checkpoint_path`] leads to, of a run that of its best network: 64 hexadecimal
/// digits, as `sha256sum` prints them.
///
/// # Errors
/// If there is none, or it cannot be read.
pub fn checkpoint_sha256(given: &Path) -> Result<String> {
    sha256(&network_file(&checkpoint_path(given)?)?)
}

/// SHA-256 of a file, as `sha256sum` prints it.
///
/// # Errors
/// If it cannot be read.
pub fn sha256(file: &Path) -> Result<String> {
    let bytes = fs::read(file).with_context(|| format!("reading {}", file.display()))?;
    Ok(format!("{:x}", Sha256::digest(bytes)))
}

/// Message for a checkpoint that is neither a file, nor a run directory, nor a shipped network.
pub fn unknown_checkpoint(given: &Path) -> String {
    let names = NETWORKS.names();
    let shipped = if names.is_empty() {
        format!(
            "this program was built without networks, and no directory `{CHECKPOINTS}` here, above \
             the program or in ${DATA} has one of that name"
        )
    } else {
        format!("no shipped network of that name (there are {})", names.join(", "))
    };
    format!("{}: no such file or run directory, and {shipped}", given.display())
}

const NO_DATA: &str =
    "nowhere to write the networks of the program: set EVPOSE_DATA to a directory";

fn path_below<'a>(given: &Path, directories: impl Iterator<Item = &'a Path>) -> PathBuf {
    let is_name = given.components().count() == 1 && given.extension().is_none();
    // What is there wins over a shipped network of the same name.
    if given.exists() || !is_name {
        return given.to_owned();
    }
    let file = Path::new(CHECKPOINTS).join(given).with_extension("bpk");
    let mut files = directories.map(|directory| directory.join(&file));
    files.find(|file| file.exists()).unwrap_or_else(|| given.to_owned())
}

/// The directory of a user's data, by the convention of the system.
fn user_data() -> Option<PathBuf> {
    let directory = |variable| env::var_os(variable).map(PathBuf::from);
    let base = if cfg!(windows) {
        directory("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        directory("HOME").map(|home| home.join("Library/Application Support"))
    } else {
        let home = || directory("HOME").map(|home| home.join(".local/share"));
        directory("XDG_DATA_HOME").or_else(home)
    };
    base.map(|base| base.join("evpose"))
}

/// The file of an embedded network, in a directory of this version of the program.
fn unpack(network: &EmbeddedNetwork, data: &Path) -> Result<PathBuf> {
    let directory = data.join(env!("CARGO_PKG_VERSION")).join(CHECKPOINTS);
    let path = directory.join(network.name).with_extension("bpk");
    // A file that was damaged since is written again.
    if fs::read(&path).is_ok_and(|bytes| bytes == network.bytes) {
        return Ok(path);
    }
    let context = || format!("writing the network `{}` to {}", network.name, path.display());
    fs::create_dir_all(&directory).with_context(context)?;
    atomic_write(&path, network.bytes).with_context(context)?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_found_above_and_a_path_stays() {
        let root = tempfile::tempdir().unwrap();
        let bin = root.path().join("target/release");
        fs::create_dir_all(&bin).unwrap();
        fs::create_dir(root.path().join(CHECKPOINTS)).unwrap();
        let shipped = root.path().join(CHECKPOINTS).join("some-network.bpk");
        fs::write(&shipped, "").unwrap();
        let found = |given: &str| path_below(Path::new(given), bin.ancestors());
        assert_eq!(found("some-network"), shipped);
        assert_eq!(found("no-such-network"), Path::new("no-such-network"));
        assert_eq!(found("runs/some-network"), Path::new("runs/some-network"));
        assert_eq!(found("some-network.bpk"), Path::new("some-network.bpk"));
    }

    #[test]
    fn an_embedded_network_is_written_once_and_replaced_if_it_differs() {
        let data = tempfile::tempdir().unwrap();
        let network = EmbeddedNetwork { name: "some-network", bytes: b"weights", card: "" };
        let path = unpack(&network, data.path()).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"weights");
        let written = fs::metadata(&path).unwrap().modified().unwrap();
        assert_eq!(unpack(&network, data.path()).unwrap(), path);
        assert_eq!(fs::metadata(&path).unwrap().modified().unwrap(), written);
        fs::write(&path, "damaged").unwrap();
        assert_eq!(fs::read(unpack(&network, data.path()).unwrap()).unwrap(), b"weights");
    }

    #[test]
    fn a_name_without_a_network_is_explained() {
        let message = unknown_checkpoint(Path::new("foot"));
        assert!(message.starts_with("foot: no such file or run directory"), "{message}");
        assert!(message.contains("built without networks"), "{message}");
    }

    #[test]
    fn a_data_directory_that_cannot_be_written_is_named() {
        let data = tempfile::NamedTempFile::new().unwrap();
        let network = EmbeddedNetwork { name: "some-network", bytes: b"weights", card: "" };
        let error = format!("{:#}", unpack(&network, data.path()).unwrap_err());
        assert!(error.starts_with("writing the network `some-network` to "), "{error}");
    }
}
