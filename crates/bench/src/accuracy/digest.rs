//! Digests of files and directories.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use evpose_cli::shipped::sha256;
use sha2::{Digest as _, Sha256};

/// SHA-256 in hexadecimal digits.
pub(super) fn of_bytes(bytes: &[u8]) -> String {
    format!("{:x}", Sha256::digest(bytes))
}

/// The digest of a file, or of the lines that `sha256sum` writes for all files of a directory, in the order of
/// their paths. Pages (`.md`) do not count: a set is the same, whatever is written about it.
///
/// # Errors
/// If a file cannot be read.
pub(super) fn of_path(path: &Path) -> Result<String> {
    if path.is_file() {
        return sha256(path);
    }
    let mut files = Vec::new();
    list(path, &mut files)?;
    let mut lines = Vec::with_capacity(files.len());
    for file in files {
        // The same digest on Windows.
        let name = file.strip_prefix(path)?.to_string_lossy().replace('\\', "/");
        lines.push((name, of_path(&file)?));
    }
    // After the names are made, since separators sort differently from system to system.
    lines.sort();
    let lines: String = lines.iter().map(|(name, digest)| format!("{digest}  {name}\n")).collect();
    Ok(of_bytes(lines.as_bytes()))
}

fn list(directory: &Path, files: &mut Vec<PathBuf>) -> Result<()> {
    let context = || format!("reading {}", directory.display());
    for entry in directory.read_dir().with_context(context)? {
        let path = entry.with_context(context)?.path();
        if path.is_dir() {
            list(&path, files)?;
        } else if path.extension().is_none_or(|ending| ending != "md") {
            files.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_is_the_list_of_its_files() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("b")).unwrap();
        std::fs::write(folder.path().join("b/x"), "abc").unwrap();
        std::fs::write(folder.path().join("a"), "").unwrap();
        std::fs::write(folder.path().join("README.md"), "what it is").unwrap();
        let list = format!("{}  a\n{}  b/x\n", of_bytes(b""), of_bytes(b"abc"));
        assert_eq!(of_path(folder.path()).unwrap(), of_bytes(list.as_bytes()));
        // FIPS 180-4's example.
        assert!(of_bytes(b"abc").starts_with("ba7816bf8f01cfea"));
    }
}
