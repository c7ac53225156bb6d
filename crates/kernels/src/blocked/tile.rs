//! The micro-kernel: sums of a few pixels and one or two blocks of channels, all in registers.

pub use crate::activation::Activation;
use crate::simd::{LANES, Lanes};

/// Sums that a tile begins with.
#[derive(Clone, Copy)]
pub(super) enum Start {
    Zero,
    /// These channels, for every pixel.
    Bias(*const f32),
    /// What stands where the tile is written.
    Output,
}

/// What is done to whole sums.
#[derive(Clone, Copy)]
pub(super) struct End {
    /// Pixels to add, laid out as the output; null for none.
    pub(super) residual: *const f32,
    /// From a block of it to the next.
    pub(super) residual_pitch: usize,
    pub(super) activation: Activation,
}

/// Which inputs a tile takes. Distances are in `f32`.
#[derive(Clone, Copy)]
pub(super) struct Taps {
    /// Blocks of input channels, and from one to the next.
    pub(super) blocks: usize,
    pub(super) block_pitch: usize,
    /// Channels of the last of them.
    pub(super) last_channels: usize,
    /// Rows and columns of the kernel, and from a row to the next.
    pub(super) kernel: usize,
    pub(super) row_pitch: usize,
    /// From a channel of a pixel to the next: 1 in blocks of channels.
    pub(super) channel_pitch: usize,
    /// Lines that are needed soon, which are fetched while products are added: one for each channel,
    /// as many as are asked for at once hold up what is needed now.
    pub(super) ahead: *const f32,
    pub(super) ahead_lines: usize,
}

/// Adds what `N` neighbouring outputs of `B` blocks of channels get from `taps`. From a pixel of the input to
/// the next are `PIXEL` values: 16 in blocks of channels, 1 in planes.
///
/// Weights are `[block][ky][kx][channel][B * 16]`.
///
/// # Safety
/// The processor has the instructions of `V`. Readable are the taps of `N` pixels `STRIDE` apart from
/// `from` on, their weights, and 16 values of the bias for each block; writable are `N` pixels of `B`
/// blocks, `pitch` apart, from `to` on; readable is as much of the residual, if there is one.
#[inline(always)]
pub(super) unsafe fn tile<
    V: Lanes,
    const N: usize,
    const B: usize,
    const STRIDE: usize,
    const PIXEL: usize,
>(
    taps: &Taps,
    from: *const f32,
    mut weights: *const f32,
    start: Start,
    (to, pitch): (*mut f32, usize),
    end: Option<&End>,
) {
    // SAFETY: the caller's; every offset below is of a pixel, a weight or a sum that is named there.
    unsafe {
        let mut sums = [[V::splat(0.0); B]; N];
        match start {
            Start::Zero => {}
            Start::Bias(bias) => {
                let bias: [V; B] = std::array::from_fn(|block| V::load(bias.add(block * LANES)));
                sums = [bias; N];
            }
            Start::Output => {
                for (pixel, sums) in sums.iter_mut().enumerate() {
                    for (block, sum) in sums.iter_mut().enumerate() {
                        *sum = V::load(to.add(block * pitch + pixel * LANES));
                    }
                }
            }
        }
        let channel_pitch = if PIXEL == LANES { 1 } else { taps.channel_pitch };
        let mut fetched = 0;
        for block in 0..taps.blocks {
            let channels = if block + 1 == taps.blocks { taps.last_channels } else { LANES };
            for ky in 0..taps.kernel {
                for kx in 0..taps.kernel {
                    let from =
                        from.add(block * taps.block_pitch + ky * taps.row_pitch + kx * PIXEL);
                    for channel in 0..channels {
                        let from = from.add(channel * channel_pitch);
                        if fetched < taps.ahead_lines {
                            V::fetch(taps.ahead.wrapping_add(fetched * LANES));
                            fetched += 1;
                        }
                        let weight: [V; B] =
                            std::array::from_fn(|block| V::load(weights.add(block * LANES)));
                        for (pixel, sums) in sums.iter_mut().enumerate() {
                            let value = V::splat(*from.add(pixel * STRIDE * PIXEL));
                            for (sum, weight) in sums.iter_mut().zip(weight) {
                                *sum = value.mul_add(weight, *sum);
                            }
                        }
                        weights = weights.add(B * LANES);
                    }
                }
            }
        }
        if let Some(end) = end {
            if !end.residual.is_null() {
                for (pixel, sums) in sums.iter_mut().enumerate() {
                    for (block, sum) in sums.iter_mut().enumerate() {
                        let at = block * end.residual_pitch + pixel * LANES;
                        *sum = sum.add(V::load(end.residual.add(at)));
                    }
                }
            }
            for sums in &mut sums {
                for sum in sums {
                    *sum = activated(*sum, end.activation);
                }
            }
        }
        for (pixel, sums) in sums.iter().enumerate() {
            for (block, sum) in sums.iter().enumerate() {
                sum.store(to.add(block * pitch + pixel * LANES));
            }
        }
    }
}

/// # Safety
/// The processor has the instructions of `V`.
#[inline(always)]
pub(super) unsafe fn activated<V: Lanes>(sum: V, activation: Activation) -> V {
    // SAFETY: the caller's.
    unsafe {
        match activation {
            Activation::Identity => sum,
            Activation::Relu => sum.max(V::splat(0.0)),
            Activation::Relu6 => sum.max(V::splat(0.0)).min(V::splat(6.0)),
        }
    }
}
