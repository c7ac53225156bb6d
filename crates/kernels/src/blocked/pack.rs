//! Packing of weights: output channels in blocks, group by group.

use rayon::prelude::*;

use super::image::Line;
use super::lines::Lines;
use crate::simd::LANES;

/// Packs `weight`, `[channels_out][channels_in][taps]`, for groups of `blocks_per_group` output channel blocks: a
/// group has `blocks` lines at each position, and `position(channel_in, tap)` is any one-to-one map to
/// `0..channels_in * taps`. Channels beyond the last are zeros.
///
/// Groups are packed in parallel: the weights of a network are as many as its start-up has time for.
pub(super) fn pack(
    weight: &[f32],
    [channels_out, channels_in, taps]: [usize; 3],
    blocks_per_group: usize,
    position: impl Fn(usize, usize) -> usize + Sync,
) -> Lines {
    let positions = channels_in * taps;
    assert_eq!(weight.len(), channels_out * positions, "weights");
    let count = channels_out.div_ceil(LANES) * positions;
    // Positions are one to one, so that every line of every group and block is written.
    let mut lines = Lines::unspecified(count);
    let groups = lines.par_chunks_mut((positions * blocks_per_group).max(1)).enumerate();
    let zeros = vec![0.0; positions];
    groups.for_each(|(group, lines)| {
        let blocks = lines.len() / positions;
        for block in 0..blocks {
            let first = (group * blocks_per_group + block) * LANES;
            let row = |lane: usize| {
                let row = weight.get((first + lane) * positions..(first + lane + 1) * positions);
                row.unwrap_or(&zeros)
            };
            let rows: [&[f32]; LANES] = std::array::from_fn(row);
            for channel_in in 0..channels_in {
                for tap in 0..taps {
                    let line = std::array::from_fn(|lane| rows[lane][channel_in * taps + tap]);
                    let at = position(channel_in, tap) * blocks + block;
                    lines[at] = Line(line);
                }
            }
        }
    });
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_weight_is_in_its_place_and_the_rest_is_zero() {
        let [channels_out, channels_in, taps] = [40, 3, 2];
        let weight: Vec<f32> = (1..=channels_out * channels_in * taps).map(|i| i as f32).collect();
        let lines = pack(&weight, [channels_out, channels_in, taps], 2, |channel_in, tap| {
            tap * channels_in + channel_in
        });
        // Blocks 0 and 1 are a group, block 2 is one of its own.
        assert_eq!(lines.len(), 3 * channels_in * taps);
        for block in 0..3 {
            let (before, blocks) = if block < 2 { (0, 2) } else { (2 * channels_in * taps, 1) };
            for channel_in in 0..channels_in {
                for tap in 0..taps {
                    let at = before + (tap * channels_in + channel_in) * blocks + block % 2;
                    let expected = |lane: usize| {
                        let channel = block * LANES + lane;
                        let at = (channel * channels_in + channel_in) * taps + tap;
                        weight.get(at).copied().unwrap_or(0.0)
                    };
                    assert_eq!(lines[at].0, std::array::from_fn(expected), "{block} {channel_in}");
                }
            }
        }
    }
}
