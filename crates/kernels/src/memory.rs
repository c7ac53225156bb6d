//! The allocator's handling of freed memory.

/// Keeps freed memory in this process instead of returning it to the system, for the rest of its
/// life.
///
/// A training step frees as much as it will need again a moment later, hundreds of megabytes in
/// pieces that glibc maps one by one; the system clears every page of them anew. Kept, a step takes
/// two thirds of the time; the most memory that is used stays the same. Nothing happens with other
/// C libraries.
pub fn keep_freed_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        /// The largest value of a parameter of `mallopt`: memory is never trimmed.
        const NEVER: i32 = i32::MAX;
        /// Allocations up to 1 GiB come from the heap; glibc accepts no larger threshold.
        const MAX_HEAP_ALLOCATION: i32 = 1 << 30;
        #[expect(unsafe_code, reason = "the allocator's settings have no safe interface")]
        // SAFETY: these set values that the allocator reads; they may be set at any time.
        unsafe {
            libc::mallopt(libc::M_TRIM_THRESHOLD, NEVER);
            libc::mallopt(libc::M_MMAP_THRESHOLD, MAX_HEAP_ALLOCATION);
        }
    }
}
