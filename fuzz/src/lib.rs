//! The work of the fuzz targets: readers over arbitrary bytes, and the invariants that hold for all of them.

mod beside;
mod events;
mod models;
mod streams;

pub use beside::{evc_frames, meta, npy, png, settings, skeletons};
pub use events::{any, arrays, packets, read};
pub use models::{model, pickle};
pub use streams::streams;

use evpose_io::IoError;

/// Checks that an error names a place of the file.
///
/// # Panics
/// If bytes in memory could "not be read", or the fault lies behind their end.
fn check(error: &IoError, length: usize) {
    let message = error.to_string();
    assert!(!matches!(error, IoError::File { .. }), "memory can always be read: {error:?}");
    assert!(error.byte().is_none_or(|byte| byte <= length as u64), "beyond the end: {message}");
}
