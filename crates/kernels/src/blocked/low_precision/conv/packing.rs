//! Packed weights of low-precision convolutions.

use std::ops::Range;

use super::arithmetic::Arithmetic;
use crate::blocked::conv_shape::ConvShape;
use crate::blocked::image::Line;
use crate::blocked::lines::Lines;
use crate::simd::LANES;

/// Channels that a dot product adds up, at one tap.
#[derive(Clone, Copy)]
pub(super) struct PackedStep {
    /// None if another step has this tap: the weights are then 0.
    tap: Option<usize>,
    /// The first of the channels.
    channel: usize,
}

#[derive(Debug, Clone)]
pub(super) struct PackedWeights {
    /// `[group][step][block][16][channel]`, by the steps of the arithmetic; the innermost channels
    /// are those of one dot product.
    pub(super) lines: Lines,
    /// Steps of every group.
    pub(super) steps: usize,
}

impl PackedWeights {
    /// Packs `weight`, `[channels_out][channels_in][kernel][kernel]`, for dot products of `depth`
    /// channels.
    pub(super) fn new<W: Copy>(
        shape: ConvShape,
        groups: impl Iterator<Item = Range<usize>>,
        arithmetic: Arithmetic,
        depth: usize,
        weight: &[W],
    ) -> Self {
        let ConvShape { channels_in, channels_out, .. } = shape;
        let taps = shape.taps();
        let steps = if arithmetic == Arithmetic::Vectors {
            vector_steps(shape, depth)
        } else {
            tile_steps(shape, depth)
        };
        // None has no channel or no tap, and stays zero.
        let mut all: Vec<Option<W>> = Vec::new();
        for blocks in groups {
            for step in &steps {
                for channel_out in blocks.start * LANES..blocks.end * LANES {
                    all.extend((step.channel..step.channel + depth).map(|channel_in| {
                        let exists = channel_out < channels_out && channel_in < channels_in;
                        let kernel = channel_out * channels_in + channel_in;
                        step.tap.filter(|_| exists).map(|tap| weight[kernel * taps + tap])
                    }));
                }
            }
        }
        let bytes = all.len() * size_of::<W>();
        let mut lines = Lines::zeros(bytes.div_ceil(size_of::<Line>()));
        let to: *mut W = lines.as_mut_ptr().cast();
        for (at, weight) in all.into_iter().enumerate() {
            if let Some(weight) = weight {
                // SAFETY: there is room for all; weights that do not exist stay zero.
                unsafe { to.add(at).write(weight) };
            }
        }
        Self { lines, steps: steps.len() }
    }
}

/// `[input block][ky][kx][channel step]`, without the channels that the last block does not have.
fn vector_steps(shape: ConvShape, depth: usize) -> Vec<PackedStep> {
    let mut steps = Vec::new();
    for first in (0..shape.channels_in).step_by(LANES) {
        let channels = first..shape.channels_in.min(first + LANES);
        for tap in 0..shape.taps() {
            let step = |channel| PackedStep { tap: Some(tap), channel };
            steps.extend(channels.clone().step_by(depth).map(step));
        }
    }
    steps
}

/// `[input block][ky][tap group][tap][channel step]`, of whole blocks. A tap that the group before
/// has as well is 0.
fn tile_steps(shape: ConvShape, depth: usize) -> Vec<PackedStep> {
    let [rows, columns] = shape.kernel;
    let groups = TapGroups::new(columns, depth);
    let mut steps = Vec::new();
    for first in (0..shape.channels_in).step_by(LANES) {
        for ky in 0..rows {
            let mut next = 0;
            for group in groups.first_taps() {
                for kx in group..group + groups.taps {
                    // Groups of fixed size overlap at the end of a row: a tap must not count twice.
                    let tap = (kx >= next).then_some(ky * columns + kx);
                    let channels = (first..first + LANES).step_by(depth);
                    steps.extend(channels.map(|channel| PackedStep { tap, channel }));
                }
                next = group + groups.taps;
            }
        }
    }
    steps
}

/// Neighbouring taps of a row of the kernel that a tile multiplies at once: those whose channels,
/// which lie side by side in a block, fill a row of a tile.
#[derive(Clone, Copy)]
pub(super) struct TapGroups {
    /// Taps of a group.
    pub(super) taps: usize,
    columns: usize,
}

impl TapGroups {
    /// Groups for a kernel of `columns` columns; four bytes hold `depth` elements.
    pub(super) fn new(columns: usize, depth: usize) -> Self {
        // A row of 64 bytes is sixteen words, and a tap a word for every `depth` channels.
        Self { taps: columns.min(depth), columns }
    }

    /// The first tap of each group. All groups have as many taps, so that tiles have one shape:
    /// the last one ends with the row, and may have taps of the one before.
    pub(super) fn first_taps(self) -> impl Iterator<Item = usize> {
        let Self { taps, columns } = self;
        (0..columns.div_ceil(taps)).map(move |group| (group * taps).min(columns - taps))
    }
}
