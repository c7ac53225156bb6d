//! Files of weights mapped into memory: read where they are used, and shared by processes.

use std::io;
use std::path::Path;

use burn::tensor::Bytes;

/// The bytes of the file at `path`. A mapping begins with a page, so that tensors are as aligned as
/// they are in the file.
///
/// # Errors
/// If the file cannot be opened or mapped.
#[cfg(unix)]
#[expect(unsafe_code, reason = "the system maps a file; the contract stands at the call")]
pub(super) fn map(path: &Path) -> io::Result<Bytes> {
    use burn::tensor::AllocationProperty;

    let file = std::fs::File::open(path)?;
    if file.metadata()?.len() == 0 {
        return Ok(Bytes::from_bytes_vec(Vec::new()));
    }
    // SAFETY: the bytes must not change while they are mapped. All our files are written under a
    // temporary name and renamed, so that a new version of a file leaves the mapped one as it is.
    let mapping = unsafe { memmap2::Mmap::map(&file)? };
    Ok(Bytes::from_shared(bytes::Bytes::from_owner(mapping), AllocationProperty::File))
}

/// The bytes of the file at `path`, read: elsewhere a file cannot be replaced while it is mapped.
///
/// # Errors
/// If the file cannot be read.
#[cfg(not(unix))]
pub(super) fn map(path: &Path) -> io::Result<Bytes> {
    std::fs::read(path).map(Bytes::from_bytes_vec)
}
