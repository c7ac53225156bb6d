//! Files of the repository.

use std::process::Command;

use anyhow::{Context, Result};

/// Paths of all files under version control, from the root on.
///
/// # Errors
/// If git cannot be run.
pub(crate) fn tracked() -> Result<Vec<String>> {
    let output = Command::new("git").args(["ls-files"]).output().context("running git")?;
    Ok(String::from_utf8(output.stdout)?.lines().map(str::to_owned).collect())
}

/// The crate of a file, or its top folder.
pub(crate) fn place(path: &str) -> String {
    let has_crates = ["crates/", "benchmarks/"].iter().any(|folder| path.starts_with(folder));
    let depth = if has_crates { 2 } else { 1 };
    path.split('/').take(depth).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_belong_to_crates_or_folders() {
        assert_eq!(place("crates/io/src/lib.rs"), "crates/io");
        assert_eq!(place("benchmarks/gap/src/main.rs"), "benchmarks/gap");
        assert_eq!(place("docs/guide/live.md"), "docs");
        assert_eq!(place("README.md"), "README.md");
    }
}
