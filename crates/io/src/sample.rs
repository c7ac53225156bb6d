//! Events of tests, and all that a source has.

use std::path::PathBuf;

use evpose_core::{Event, Micros, Polarity};
use tempfile::TempDir;

use crate::{Columns, EventSource, IoError};

pub(crate) fn event(t: i64, x: u16, y: u16, on: bool) -> Event {
    Event { t: Micros(t), x, y, polarity: Polarity::from_on(on) }
}

/// A file in a folder of its own.
pub(crate) fn file(name: &str, content: impl AsRef<[u8]>) -> (TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join(name);
    std::fs::write(&path, content).unwrap();
    (directory, path)
}

/// All events, remarks, and the fault that ended them.
pub(crate) fn read_all(source: &mut dyn EventSource) -> (Columns, Vec<String>, Option<IoError>) {
    let mut columns = Columns::new();
    let fault = source.read_rest(&mut columns).err();
    (columns, source.remarks(), fault)
}

/// An array as NumPy writes it: its type and its shape as Python writes them, and its values.
pub(crate) fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n");
    let length = (header.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), data].concat()
}
