//! Channels in blocks of sixteen.

use std::ops::Range;

use super::image::Line;
use crate::simd::LANES;

/// Blocks of so many channels, as many together as are made at once; a last odd one is alone.
pub(crate) fn groups(
    channels: usize,
    together: usize,
) -> impl ExactSizeIterator<Item = Range<usize>> {
    let blocks = channels.div_ceil(LANES);
    (0..blocks.div_ceil(together))
        .map(move |group| group * together..blocks.min((group + 1) * together))
}

/// Values in blocks of sixteen, filled up with zeros.
pub(crate) fn blocks_of(values: &[f32]) -> Vec<Line> {
    let block = |values: &[f32]| {
        let mut line = Line::ZERO;
        line.0[..values.len()].copy_from_slice(values);
        line
    };
    values.chunks(LANES).map(block).collect()
}
