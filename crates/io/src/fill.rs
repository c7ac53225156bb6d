//! Reads that go on until there is enough.

use std::io::{self, ErrorKind, Read};

/// Fills `out`, and says how much of it: all, unless the end comes before.
pub(crate) fn fill(bytes: &mut (impl Read + ?Sized), out: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < out.len() {
        match bytes.read(&mut out[filled..]) {
            Ok(0) => break,
            Ok(got) => filled += got,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}
