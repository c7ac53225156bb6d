//! Files that other programs wrote, and what is in them, as `tests/golden/*/README.md` lists it.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use evpose_core::Event;
use sha2::{Digest as _, Sha256};

use crate::{OpenOptions, open_as};

/// A digest in hexadecimal.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

/// Lines `t x y polarity`.
pub(crate) fn event_lines(events: impl Iterator<Item = Event>) -> String {
    events.fold(String::new(), |mut text, e| {
        writeln!(text, "{} {} {} {}", e.t.0, e.x, e.y, e.polarity as u8).unwrap();
        text
    })
}

fn path(folder: &str, name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(folder).join(name)
}

/// The bytes of a file, which are those that were written, and the cells behind their digest in the
/// table of its folder.
pub(crate) fn listed(folder: &str, name: &str) -> (Vec<u8>, Vec<String>) {
    let bytes = fs::read(path(folder, name)).unwrap();
    let cells = |line: &str| -> Vec<String> {
        line.split('|').map(|cell| cell.trim().trim_matches('`').to_owned()).collect()
    };
    let readme = fs::read_to_string(path(folder, "README.md")).unwrap();
    let digest = sha256(&bytes);
    let row =
        readme.lines().map(cells).find(|row| row.len() > 3 && row[1] == name && row[3] == digest);
    let row = row.unwrap_or_else(|| panic!("{folder}/{name} of digest {digest} is not listed"));
    (bytes, row[4..].to_vec())
}

/// Checks that files are those that were written, are recognised as of their format, and hold the
/// events that are listed.
pub(crate) fn check(folder: &str, files: &[(&str, &str)]) {
    for (name, format) in files {
        let (_, cells) = listed(folder, name);
        let recording = open_as(path(folder, name), &OpenOptions::default()).unwrap();
        assert_eq!(recording.format, *format, "{name}");
        assert_eq!(recording.stream.len().to_string(), cells[0], "{name}");
        let lines = event_lines(recording.stream.iter());
        assert_eq!(sha256(lines.as_bytes()), cells[1], "{name}");
    }
}
