//! Files of windows: one stack, or a directory of images or arrays.

use std::ffi::OsString;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use evpose_core::{Micros, remove_abandoned_files, temporary_target};
use evpose_io::tensors::{TensorWriter, write_window};
use evpose_report::png::png;

use super::RepresentArgs;
use super::windows::WindowReader;
use crate::commands::view::Palette;
use crate::outputs::write_file;

/// Names the files of a directory and the ends of their windows.
const TABLE: &str = "windows.csv";

/// Target of the windows.
pub(super) enum Output {
    /// All in one file.
    Stack(TensorWriter),
    /// A file each.
    Directory(WindowDirectory),
}

/// Form of the output, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum OutputKind {
    Stack,
    Images,
    Arrays,
}

impl OutputKind {
    fn of(out: &Path, each: bool) -> Result<Self> {
        // A directory need not exist yet: a slash at the end says that it is one.
        let is_directory = out.is_dir() || out.to_string_lossy().ends_with(['/', '\\']);
        let ending = out.extension().and_then(|ending| ending.to_str());
        match ending.filter(|_| !is_directory) {
            None => Ok(if each { Self::Arrays } else { Self::Images }),
            Some(_) if each => {
                bail!("{}: --each writes into a directory, --out DIR/", out.display())
            }
            Some("npy" | "npz") => Ok(Self::Stack),
            Some(_) => bail!(
                "{}: the name should end in .npy or .npz, or in / as that of a directory",
                out.display()
            ),
        }
    }
}

/// Says whether the windows can be written, before a recording is read.
pub(super) fn check(args: &RepresentArgs) -> Result<()> {
    if OutputKind::of(&args.out, args.each)? == OutputKind::Stack || !args.out.is_dir() {
        return Ok(());
    }
    check_empty(&args.out)
}

/// Says whether a directory is empty but for what a killed run began, which is removed.
fn check_empty(directory: &Path) -> Result<()> {
    let names = || -> Result<Vec<_>> {
        let entries = fs::read_dir(directory)?.map(|entry| Ok(entry?.file_name()));
        entries.collect()
    };
    let is_abandoned = |name: &OsString| name.to_str().and_then(temporary_target).is_some();
    if names()?.iter().all(is_abandoned) {
        remove_abandoned_files(directory)?;
    }
    ensure!(
        names()?.is_empty(),
        "{}: the directory is not empty: remove it, or name another",
        directory.display()
    );
    Ok(())
}

impl Output {
    pub(super) fn create(args: &RepresentArgs, reader: &WindowReader) -> Result<Self> {
        let kind = OutputKind::of(&args.out, args.each)?;
        let rows_columns = [reader.size.height.into(), reader.size.width.into()];
        let [channels, rows, columns] =
            [reader.choice.channels() as u64, rows_columns[0], rows_columns[1]];
        if kind == OutputKind::Stack {
            let shape = [reader.schedule.count, channels, rows, columns];
            return Ok(Self::Stack(TensorWriter::create(&args.out, shape)?));
        }
        fs::create_dir_all(&args.out).with_context(|| format!("making {}", args.out.display()))?;
        Ok(Self::Directory(WindowDirectory {
            path: args.out.to_path_buf(),
            // As wide as the last number, so that names sort in order of time.
            digits: reader.schedule.count.to_string().len().max(6),
            palette: (kind == OutputKind::Images).then(|| Palette::new(reader.size, false)),
            shape: [channels, rows, columns],
            table: "file,t_us\n".to_owned(),
        }))
    }

    pub(super) fn write(&mut self, k: u64, end: Micros, planes: &[f32]) -> Result<()> {
        match self {
            Self::Stack(writer) => Ok(writer.write(end, planes)?),
            Self::Directory(directory) => directory.write(k, end, planes),
        }
    }

    pub(super) fn finish(self) -> Result<()> {
        match self {
            Self::Stack(writer) => Ok(writer.finish()?),
            Self::Directory(directory) => {
                // The table comes last, so that a directory with a table has all of its windows.
                let path = directory.path.join(TABLE);
                write_file(&path, directory.table)
            }
        }
    }
}

/// A directory with a file per window.
pub(super) struct WindowDirectory {
    path: PathBuf,
    digits: usize,
    /// Of images; without it, windows are arrays.
    palette: Option<Palette>,
    shape: [u64; 3],
    table: String,
}

impl WindowDirectory {
    fn write(&mut self, k: u64, end: Micros, planes: &[f32]) -> Result<()> {
        let ending = if self.palette.is_some() { "png" } else { "npy" };
        let name = format!("{k:0digits$}.{ending}", digits = self.digits);
        let path = self.path.join(&name);
        match &self.palette {
            Some(palette) => write_file(&path, &png(&palette.draw(planes))?)?,
            None => write_window(&path, self.shape, planes)?,
        }
        // Writing to a string does not fail.
        let _ = writeln!(self.table, "{name},{}", end.0);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_killed_run_began_does_not_fill_a_directory() -> Result<()> {
        let directory = tempfile::tempdir()?;
        let begun = directory.path().join("000123.png.0-0.tmp");
        fs::write(&begun, "half")?;
        check_empty(directory.path())?;
        assert!(!begun.exists());
        fs::write(directory.path().join("000122.png"), "whole")?;
        fs::write(&begun, "half")?;
        assert!(check_empty(directory.path()).is_err() && begun.exists());
        Ok(())
    }

    #[test]
    fn names_select_the_form() -> Result<()> {
        for (out, each, want) in [
            ("a.npy", false, OutputKind::Stack),
            ("a.npz", false, OutputKind::Stack),
            ("a", false, OutputKind::Images),
            ("a.b/", false, OutputKind::Images),
            ("a.npy/", true, OutputKind::Arrays),
        ] {
            assert_eq!(OutputKind::of(Path::new(out), each)?, want, "{out}");
        }
        for (out, each) in [("a.npy", true), ("a.png", false), ("a.pt", false)] {
            assert!(OutputKind::of(Path::new(out), each).is_err(), "{out}");
        }
        Ok(())
    }
}
