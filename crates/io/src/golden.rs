//! Files that other programs wrote, and what is in them, as `tests/golden/*/README.md` says.

use std::fmt::Write as _;
use std::fs;

use sha2::{Digest as _, Sha256};

use crate::{OpenOptions, open_as};

/// A digest in hexadecimal.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

/// Checks that a file is the one that was written, is recognised as of `format`, and holds `events`
/// events whose lines `t x y polarity` have the digest `lines`.
pub(crate) fn check(name: &str, format: &str, file: &str, events: usize, lines: &str) {
    let path = format!("{}/tests/golden/{name}", env!("CARGO_MANIFEST_DIR"));
    assert_eq!(sha256(&fs::read(&path).unwrap()), file, "{name}");
    let recording = open_as(&path, &OpenOptions::default()).unwrap();
    assert_eq!((recording.format, recording.stream.len()), (format, events), "{name}");
    let text = recording.stream.iter().fold(String::new(), |mut text, e| {
        writeln!(text, "{} {} {} {}", e.t.0, e.x, e.y, e.polarity as u8).unwrap();
        text
    });
    assert_eq!(sha256(text.as_bytes()), lines, "{name}");
}
