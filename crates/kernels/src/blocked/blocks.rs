//! Channels in blocks of [`LANES`], as nChw16c stores them.

use std::ops::Range;

use super::Part;
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

/// The groups of output channels that a part computes, and the rows of each, of `rows` rows. Neighbouring ones: threads
/// then divide the weights among them in place of reading all of them each, whatever their number.
pub(crate) fn rows_by_group(
    part: Part,
    groups: usize,
    rows: usize,
) -> impl Iterator<Item = (usize, Range<usize>)> {
    let units = part.chunk(groups * rows);
    (units.start / rows..units.end.div_ceil(rows)).map(move |group| {
        let in_group = |unit: usize| unit.saturating_sub(group * rows).min(rows);
        (group, in_group(units.start)..in_group(units.end))
    })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_divide_all_rows_of_all_groups_and_share_few_groups() {
        for (groups, rows) in [(16, 6), (3, 5), (1, 7), (2, 1)] {
            for count in 1..20 {
                let mut seen = vec![0; groups * rows];
                let mut read = 0;
                for index in 0..count {
                    for (group, of_group) in rows_by_group(Part { index, count }, groups, rows) {
                        read += 1;
                        of_group.for_each(|row| seen[group * rows + row] += 1);
                    }
                }
                assert!(seen.iter().all(|times| *times == 1), "{groups} by {rows}, {count} parts");
                // All groups once, and again only where the next thread begins.
                assert!(read < groups + count, "{read} of {groups}, {count} parts");
            }
        }
    }
}
