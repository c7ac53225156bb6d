//! Results as lines of JSON, one a case, that a run which was cut off leaves readable.

use std::fs::File;
use std::io::Write as _;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::files;

/// Reads results to go on behind them: a last line that was cut off is removed.
pub(super) fn resume<R: DeserializeOwned>(path: &Path) -> Result<Vec<R>> {
    if !path.is_file() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let whole = whole_lines(&text);
    if whole.len() < text.len() {
        evpose_core::atomic_write(path, whole.as_bytes())?;
    }
    parse(whole, path)
}

/// Begins or goes on with a file of results: those that it holds, and where others are appended.
pub(super) fn begin<R: DeserializeOwned>(
    dir: &Path,
    name: &str,
    is_resumed: bool,
) -> Result<(Vec<R>, File)> {
    let path = dir.join(name);
    let known: Vec<R> = if is_resumed { resume(&path)? } else { Vec::new() };
    if known.is_empty() {
        files::write(dir, name, b"")?;
    }
    let file = File::options().append(true).open(&path);
    Ok((known, file.with_context(|| format!("opening {}", path.display()))?))
}

/// Appends a result in one piece, so that a run that is cut off leaves whole lines.
pub(super) fn append(file: &mut File, row: &impl Serialize) -> Result<()> {
    file.write_all(line(row)?.as_bytes()).context("writing results.jsonl")
}

pub(super) fn line(row: &impl Serialize) -> Result<String> {
    Ok(format!("{}\n", serde_json::to_string(row)?))
}

/// Sorts cases by their names; two of one name are refused.
pub(super) fn sort<R>(rows: &mut [R], id: impl Fn(&R) -> &str) -> Result<()> {
    rows.sort_by(|a, b| id(a).cmp(id(b)));
    for pair in rows.windows(2) {
        ensure!(id(&pair[0]) != id(&pair[1]), "case {} is there twice", id(&pair[0]));
    }
    Ok(())
}

/// Reads results; a last line that was cut off is skipped.
pub(super) fn read<R: DeserializeOwned>(path: &Path) -> Result<Vec<R>> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    parse(whole_lines(&text), path)
}

/// A text up to the end of its last whole line.
pub(super) fn whole_lines(text: &str) -> &str {
    &text[..text.rfind('\n').map_or(0, |end| end + 1)]
}

fn parse<R: DeserializeOwned>(text: &str, path: &Path) -> Result<Vec<R>> {
    let row = |(i, line)| {
        serde_json::from_str(line).with_context(|| format!("{}: line {}", path.display(), i + 1))
    };
    text.lines().enumerate().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_torn_line_is_removed_and_a_wrong_one_is_an_error() -> Result<()> {
        let dir = tempfile::tempdir()?;
        let path = dir.path().join("results.jsonl");
        std::fs::write(&path, "1\n2\n3")?;
        assert_eq!(read::<u32>(&path)?, [1, 2]);
        assert_eq!(resume::<u32>(&path)?, [1, 2]);
        assert_eq!(std::fs::read_to_string(&path)?, "1\n2\n");
        std::fs::write(&path, "1\nx\n")?;
        assert!(read::<u32>(&path).unwrap_err().to_string().contains("line 2"));
        assert!(resume::<u32>(&dir.path().join("none"))?.is_empty());
        Ok(())
    }
}
