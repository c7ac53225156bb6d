//! Writes stacks window by window.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, Micros};
use zip::write::{StreamWriter, ZipWriter};

use super::{FRAMES, StackShape, TIMES, VALUE_TYPE};
use crate::IoError;
use crate::npz::{header_for, start_array};

/// A stack that is being written. Its file appears when it is finished.
pub struct TensorWriter {
    path: PathBuf,
    shape: StackShape,
    target: Target,
    /// Ends of the windows so far.
    ends: Vec<Micros>,
    bytes: Vec<u8>,
}

enum Target {
    Array(AtomicFile),
    Archive(Box<ZipWriter<StreamWriter<AtomicFile>>>),
}

impl TensorWriter {
    /// Begins a file, `.npy` or `.npz` by its extension.
    ///
    /// # Errors
    /// If the name has another extension, or the file cannot be created.
    pub fn create(path: impl AsRef<Path>, shape: StackShape) -> Result<Self, IoError> {
        let path = path.as_ref().to_owned();
        let failed = |e| IoError::file(&path, "create", e);
        let create = || AtomicFile::create(&path).map_err(failed);
        // The header comes first and names the number of windows: `write` refuses more.
        let header = header_for(VALUE_TYPE, &shape, &shape);
        let target = match path.extension().and_then(|ending| ending.to_str()) {
            Some("npy") => {
                let mut file = create()?;
                file.write_all(&header).map_err(failed)?;
                Target::Array(file)
            }
            Some("npz") => {
                let mut zip = ZipWriter::new_stream(create()?);
                start_array(&mut zip, FRAMES).map_err(failed)?;
                zip.write_all(&header).map_err(failed)?;
                Target::Archive(Box::new(zip))
            }
            _ => return Err(IoError::UnknownEnding { path, known: ".npy, .npz".to_owned() }),
        };
        Ok(Self { path, shape, target, ends: Vec::new(), bytes: Vec::new() })
    }

    /// Appends the planes of the window that ends at `end`, `[channels][rows][columns]`.
    ///
    /// # Errors
    /// If they are of another shape or one too many, or if writing fails.
    pub fn write(&mut self, end: Micros, planes: &[f32]) -> Result<(), IoError> {
        let [windows, window @ ..] = self.shape;
        if planes.len() as u64 != window.iter().product::<u64>()
            || self.ends.len() as u64 == windows
        {
            let reason = format!("{} values of window {}", planes.len(), self.ends.len());
            let of = format!("a stack of {windows} windows of {window:?}");
            return Err(IoError::unwritable(&self.path, format!("{reason}, in {of}")));
        }
        self.ends.push(end);
        self.bytes.clear();
        self.bytes.extend(planes.iter().flat_map(|value| value.to_le_bytes()));
        let written = match &mut self.target {
            Target::Array(file) => file.write_all(&self.bytes),
            Target::Archive(zip) => zip.write_all(&self.bytes),
        };
        written.map_err(|e| IoError::file(&self.path, "write", e))
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// If windows are missing, or writing fails.
    pub fn finish(self) -> Result<(), IoError> {
        let Self { path, shape: [windows, ..], target, ends, .. } = self;
        if ends.len() as u64 != windows {
            let reason = format!("{} of its {windows} windows are there", ends.len());
            return Err(IoError::unwritable(&path, reason));
        }
        let finished = match target {
            Target::Array(file) => file.commit(),
            Target::Archive(zip) => finish_archive(*zip, &ends),
        };
        finished.map_err(|e| IoError::file(&path, "write", e))
    }
}

fn finish_archive(mut zip: ZipWriter<StreamWriter<AtomicFile>>, ends: &[Micros]) -> io::Result<()> {
    let shape = [ends.len() as u64];
    start_array(&mut zip, TIMES)?;
    zip.write_all(&header_for("'<i8'", &shape, &shape))?;
    let times: Vec<u8> = ends.iter().flat_map(|t| t.0.to_le_bytes()).collect();
    zip.write_all(&times)?;
    zip.finish()?.into_inner().commit()
}

/// Writes one window as a `.npy` file, `[channels, rows, columns]`.
///
/// # Errors
/// If writing fails.
pub fn write_window(
    path: impl AsRef<Path>,
    shape: [u64; 3],
    planes: &[f32],
) -> Result<(), IoError> {
    let path = path.as_ref();
    let mut bytes = header_for(VALUE_TYPE, &shape, &shape);
    bytes.extend(planes.iter().flat_map(|value| value.to_le_bytes()));
    evpose_core::atomic_write(path, &bytes).map_err(|e| IoError::file(path, "write", e))
}
