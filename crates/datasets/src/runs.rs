//! Runs of items that follow each other.

use std::ops::Range;

/// Places of the runs in which each item goes on with the one before.
pub(crate) fn runs<T>(items: &[T], goes_on: impl FnMut(&T, &T) -> bool) -> Vec<Range<usize>> {
    let mut end = 0;
    let run = |run: &[T]| {
        end += run.len();
        end - run.len()..end
    };
    items.chunk_by(goes_on).map(run).collect()
}
