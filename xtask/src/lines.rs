//! `cargo xtask lines`: limits the size of the command line.
//!
//! Commands parse arguments and print results; work that grows them beyond their limit belongs into
//! a library.

use anyhow::{Context, Result, bail};

use crate::files;

/// Folders of the command line: the program, and what its commands do.
const CLI: [&str; 2] = ["src/", "crates/cli/src/commands/"];
/// Maximum lines of Rust in them, tests included: a third above its size when benches, reports and
/// ablations moved into crates.
const MAX_CLI_LINES: usize = 9_000;

/// Prints the lines of Rust of every crate.
///
/// # Errors
/// If the command line is over its limit, or a file cannot be read.
pub(crate) fn run(_: &[String], say: fn(&str)) -> Result<()> {
    let mut counts = std::collections::BTreeMap::<String, usize>::new();
    let mut cli_lines = 0;
    for path in files::tracked()?.into_iter().filter(|path| path.ends_with(".rs")) {
        // Files that are deleted but not yet committed.
        if !std::path::Path::new(&path).is_file() {
            continue;
        }
        let text = std::fs::read_to_string(&path).with_context(|| format!("reading {path}"))?;
        let lines = text.lines().count();
        *counts.entry(files::place(&path)).or_default() += lines;
        if CLI.iter().any(|folder| path.starts_with(folder)) {
            cli_lines += lines;
        }
    }
    for (place, count) in &counts {
        say(&format!("{count:>7}  {place}"));
    }
    check(cli_lines)
}

fn check(cli_lines: usize) -> Result<()> {
    if cli_lines > MAX_CLI_LINES {
        bail!(
            "{}: {cli_lines} lines of Rust, at most {MAX_CLI_LINES}: move work into a library",
            CLI.join(" and ")
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_has_a_limit() {
        assert!(check(MAX_CLI_LINES).is_ok());
        assert!(check(MAX_CLI_LINES + 1).is_err());
    }
}
