//! Channels in blocks of [`LANES`], as nChw16c stores them.

use std::ops::Range;

use super::image::Line;
use crate::simd::LANES;

/// Splits the blocks of `channels` channels into groups of `blocks_per_group` that a kernel
/// computes at once; the last group may be shorter.
pub(crate) fn block_groups(
    channels: usize,
    blocks_per_group: usize,
) -> impl ExactSizeIterator<Item = Range<usize>> {
    let blocks = channels.div_ceil(LANES);
    (0..blocks.div_ceil(blocks_per_group))
        .map(move |group| group * blocks_per_group..blocks.min((group + 1) * blocks_per_group))
}

/// One value per channel (a bias, a scale) in whole blocks, padded with zeros.
pub(crate) fn pad_to_blocks(values: &[f32]) -> Vec<Line> {
    let block = |values: &[f32]| {
        let mut line = Line::ZERO;
        line.0[..values.len()].copy_from_slice(values);
        line
    };
    values.chunks(LANES).map(block).collect()
}
