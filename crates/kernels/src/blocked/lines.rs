//! Cache lines in huge pages: the memory of weights and images.
//!
//! The weights of a network are tens of megabytes that every inference reads once. In pages of 4 KiB they exceed
//! what the processor keeps translations of, and a new process waits for the system to clear each page. All lines
//! come from chunks of memory for which the system is asked for pages of 2 MiB (transparent huge pages; Linux),
//! one behind the other. Without such pages nothing changes but the time.

use std::fmt;
use std::ops::{Deref, DerefMut};
use std::ptr::NonNull;
use std::sync::{Arc, Mutex, PoisonError};

use memmap2::MmapMut;

use super::image::Line;

/// Size of a huge page, to whose multiples chunks are aligned.
const HUGE_PAGE: usize = 2 << 20;
/// Bytes of a chunk that several arrays share: only pages that are written exist.
const CHUNK: usize = 32 << 20;

/// An array of lines, as a `Vec` that does not grow.
pub(crate) struct Lines {
    first: NonNull<Line>,
    count: usize,
    /// Keeps the memory; none of an empty array.
    _chunk: Option<Arc<Chunk>>,
}

/// A mapping, from which arrays are cut.
struct Chunk {
    first: NonNull<Line>,
    lines: usize,
    _mapping: MmapMut,
}

/// The chunk that the next arrays come from.
struct OpenChunk {
    chunk: Arc<Chunk>,
    /// Lines that are given away.
    used: usize,
}

static OPEN: Mutex<Option<OpenChunk>> = Mutex::new(None);

impl Lines {
    pub(crate) fn zeros(count: usize) -> Self {
        let mut lines = Self::unspecified(count);
        lines.fill(Line::ZERO);
        lines
    }

    /// `count` lines of unspecified values, for those who write them all.
    ///
    /// # Panics
    /// If the system has no memory.
    pub(crate) fn unspecified(count: usize) -> Self {
        if count == 0 {
            return Self::default();
        }
        let (chunk, first) = take(count);
        // SAFETY: the chunk has that many lines from there on.
        let first = unsafe { chunk.first.add(first) };
        Self { first, count, _chunk: Some(chunk) }
    }
}

/// A chunk with `count` lines that nobody else has, and the first of them.
fn take(count: usize) -> (Arc<Chunk>, usize) {
    if count * size_of::<Line>() > CHUNK / 2 {
        return (Arc::new(Chunk::map(count)), 0);
    }
    let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(OpenChunk { chunk, used }) = &mut *open {
        // Every array of it is gone.
        if Arc::get_mut(chunk).is_some() {
            *used = 0;
        }
        if *used + count <= chunk.lines {
            let first = *used;
            *used += count;
            return (Arc::clone(chunk), first);
        }
    }
    let chunk = Arc::new(Chunk::map(CHUNK / size_of::<Line>()));
    *open = Some(OpenChunk { chunk: Arc::clone(&chunk), used: count });
    (chunk, 0)
}

impl Chunk {
    fn map(lines: usize) -> Self {
        let bytes = lines * size_of::<Line>();
        let mut mapping = MmapMut::map_anon(bytes + HUGE_PAGE)
            .unwrap_or_else(|error| panic!("{bytes} bytes for weights and images: {error}"));
        let before = mapping.as_ptr().align_offset(HUGE_PAGE);
        #[cfg(target_os = "linux")]
        // It may be refused: the pages are small then.
        let _ = mapping.advise_range(memmap2::Advice::HugePage, before, bytes);
        let first = mapping[before..].as_mut_ptr().cast();
        let first = NonNull::new(first).unwrap_or_else(|| unreachable!("a mapping has an address"));
        Self { first, lines, _mapping: mapping }
    }
}

// SAFETY: an array is the only owner of its lines, and a mapping may be unmapped by any thread.
unsafe impl Send for Lines {}
// SAFETY: lines are changed through `&mut` alone.
unsafe impl Sync for Lines {}
// SAFETY: as above; a chunk itself is not written through.
unsafe impl Send for Chunk {}
// SAFETY: as above.
unsafe impl Sync for Chunk {}

impl Deref for Lines {
    type Target = [Line];

    fn deref(&self) -> &[Line] {
        // SAFETY: the lines are this array's, and any bits are values: new mappings are zero.
        unsafe { std::slice::from_raw_parts(self.first.as_ptr(), self.count) }
    }
}

impl DerefMut for Lines {
    fn deref_mut(&mut self) -> &mut [Line] {
        // SAFETY: as above; nobody else has them.
        unsafe { std::slice::from_raw_parts_mut(self.first.as_ptr(), self.count) }
    }
}

impl Default for Lines {
    fn default() -> Self {
        Self { first: NonNull::dangling(), count: 0, _chunk: None }
    }
}

impl Clone for Lines {
    fn clone(&self) -> Self {
        let mut lines = Self::unspecified(self.count);
        lines.copy_from_slice(self);
        lines
    }
}

impl fmt::Debug for Lines {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_apart_and_keep_their_values() {
        let mut arrays: Vec<Lines> = [0, 1, 3, 70_000, 300_000, 2].map(Lines::zeros).into();
        for (value, array) in arrays.iter_mut().enumerate() {
            assert!(array.iter().all(|line| *line == Line::ZERO));
            array.fill(Line([value as f32; 16]));
        }
        let copy = arrays[3].clone();
        drop(arrays.remove(1));
        for (array, value) in arrays.iter().zip([0.0, 2.0, 3.0, 4.0, 5.0]) {
            assert!(array.iter().all(|line| line.0 == [value; 16]));
            assert!(array.as_ptr().is_aligned());
        }
        assert_eq!(copy[..], arrays[2][..]);
    }

    #[test]
    fn threads_get_arrays_of_their_own() {
        let filled = |value: usize| {
            move || {
                let mut array = Lines::zeros(1_000 + value);
                array.fill(Line([value as f32; 16]));
                array
            }
        };
        let threads: Vec<_> = (0..8).map(|value| std::thread::spawn(filled(value))).collect();
        for (value, thread) in threads.into_iter().enumerate() {
            let Ok(array) = thread.join() else { panic!("a thread failed") };
            assert!(array.iter().all(|line| line.0 == [value as f32; 16]));
        }
    }
}
