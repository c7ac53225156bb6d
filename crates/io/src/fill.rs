//! Reads that go on until there is enough.

use std::io::{self, ErrorKind, Read};

/// Fills `out`, and says how much of it: all, unless the end comes before.
pub(crate) fn fill(bytes: &mut (impl Read + ?Sized), out: &mut [u8]) -> io::Result<usize> {
    match fill_to_fault(bytes, out) {
        (filled, None) => Ok(filled),
        (_, Some(error)) => Err(error),
    }
}

/// Fills `out`, and says how much of it, and the fault that reading ended with.
pub(crate) fn fill_to_fault(
    bytes: &mut (impl Read + ?Sized),
    out: &mut [u8],
) -> (usize, Option<io::Error>) {
    let mut filled = 0;
    while filled < out.len() {
        match bytes.read(&mut out[filled..]) {
            Ok(0) => break,
            Ok(got) => filled += got,
            // A signal came in between: no byte is lost.
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return (filled, Some(error)),
        }
    }
    (filled, None)
}
