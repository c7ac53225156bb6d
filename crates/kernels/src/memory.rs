//! What becomes of memory that is given back.

/// Keeps freed memory in this process instead of giving it back to the system, for the rest of its life.
///
/// A training step frees as much as it will need again a moment later, hundreds of megabytes in pieces that
/// glibc maps one by one; the system clears every page of them anew. Kept, a step takes two thirds of the
/// time; the most memory that is used stays the same. Nothing happens with other C libraries.
pub fn keep_freed_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        /// As large as the parameters of `mallopt` can be.
        const NEVER: i32 = i32::MAX;
        // Allocations up to the largest size that glibc takes from its heap.
        const LARGEST: i32 = 1 << 30;
        #[expect(unsafe_code, reason = "the allocator has no other way to be told")]
        // SAFETY: these set numbers that the allocator reads; they may be set at any time.
        unsafe {
            libc::mallopt(libc::M_TRIM_THRESHOLD, NEVER);
            libc::mallopt(libc::M_MMAP_THRESHOLD, LARGEST);
        }
    }
}
