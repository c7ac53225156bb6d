//! Weights in the order in which the kernels read them.

use rayon::prelude::*;

use crate::blocked::Line;
use crate::simd::LANES;

/// The weights of a convolution, `[channels_out][channels_in][taps]`, or of its transpose.
#[derive(Clone, Copy)]
pub(super) struct Weights<'a> {
    pub(super) values: &'a [f32],
    /// Channels of output and input of the layer, taps of its kernel.
    pub(super) shape: [usize; 3],
    /// Whether the transposed convolution, that is the gradient by the input, is computed.
    pub(super) is_transposed: bool,
}

impl Weights<'_> {
    /// Channels that come out and go in.
    pub(super) fn channels(&self) -> [usize; 2] {
        let [rows, columns, _] = self.shape;
        if self.is_transposed { [columns, rows] } else { [rows, columns] }
    }

    /// From an output channel to the next, and from an input channel to the next.
    pub(super) fn pitches(&self) -> [usize; 2] {
        let [_, columns, taps] = self.shape;
        if self.is_transposed { [taps, columns * taps] } else { [columns * taps, taps] }
    }

    /// As `[group][input block][tap][channel][block][16]`, of these taps.
    pub(super) fn packed(&self, taps: &[usize], at_once: usize) -> Vec<Line> {
        let [channels_out, channels_in] = self.channels();
        let [out_pitch, in_pitch] = self.pitches();
        let blocks = channels_out.div_ceil(LANES);
        let of_block = channels_in * taps.len();
        let mut lines = vec![Line::ZERO; blocks * of_block];
        if of_block == 0 {
            return lines;
        }
        lines.par_chunks_mut(at_once * of_block).enumerate().for_each(|(group, lines)| {
            let blocks = lines.len() / of_block;
            for (block_in, first) in (0..channels_in).step_by(LANES).enumerate() {
                let channels = LANES.min(channels_in - first);
                let lines = &mut lines[block_in * LANES * taps.len() * blocks..];
                for block in 0..blocks {
                    let first_out = (group * at_once + block) * LANES;
                    // Lanes without a channel stay zero.
                    for lane in 0..LANES.min(channels_out - first_out) {
                        let values = &self.values[(first_out + lane) * out_pitch..];
                        for channel in 0..channels {
                            let values = &values[(first + channel) * in_pitch..];
                            for (k, tap) in taps.iter().enumerate() {
                                let line = (k * channels + channel) * blocks + block;
                                lines[line].0[lane] = values[*tap];
                            }
                        }
                    }
                }
            }
        });
        lines
    }
}
