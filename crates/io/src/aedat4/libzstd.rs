//! Zstandard frames decompressed by its C library, which takes four fifths of the time of `zrip`.
//!
//! It only takes frames that state what they hold, as every recorder writes them, and that are
//! whole. The others, and all words about faults, are left to `zrip`: recordings read the same
//! with the library as without.

use zstd::bulk::Decompressor;
use zstd::zstd_safe::get_frame_content_size;

/// A context of the library, for one frame after the other.
pub(super) struct LibZstd(Decompressor<'static>);

impl LibZstd {
    /// A context, if there is memory for it.
    pub(super) fn new() -> Option<Self> {
        Decompressor::new().ok().map(Self)
    }

    /// Replaces the content of `out` by what `frame` was compressed from, at most `limit` bytes;
    /// returns whether it did.
    pub(super) fn decompress(&mut self, frame: &[u8], limit: usize, out: &mut Vec<u8>) -> bool {
        let Ok(Some(length)) = get_frame_content_size(frame) else { return false };
        let Some(length) = usize::try_from(length).ok().filter(|&length| length <= limit) else {
            return false;
        };
        out.clear();
        out.reserve_exact(length);
        // It writes no more than there is room for.
        self.0.decompress_to_buffer(frame, out).is_ok() && out.len() == length
    }
}
