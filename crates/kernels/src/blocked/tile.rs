//! Micro-kernel of direct convolution and Winograd's batched GEMM: a register tile of a few pixels
//! by one or two blocks of channels.

pub use crate::activation::Activation;
use crate::simd::{LANES, Lanes};

/// Initial values of a tile's accumulators.
#[derive(Clone, Copy)]
pub(super) enum AccumulatorInit {
    Zero,
    /// The bias of the tile's channels, for every pixel.
    Bias(*const f32),
    /// The partial sums that an earlier call stored at the destination.
    Dst,
}

/// Post-operations on finished sums: residual sum, then activation.
#[derive(Clone, Copy)]
pub(super) struct Epilogue {
    /// Pixels to add, in the layout of the destination; null for none.
    pub(super) residual: *const f32,
    /// Distance between channel blocks of the residual.
    pub(super) residual_pitch: usize,
    pub(super) activation: Activation,
}

/// Window of inputs that a tile sums over. Pitches are in `f32`.
#[derive(Clone, Copy)]
pub(super) struct InputWindow {
    /// Blocks of input channels.
    pub(super) blocks: usize,
    /// Distance between them.
    pub(super) block_pitch: usize,
    /// Channels of the last block.
    pub(super) last_channels: usize,
    /// Rows and columns of the kernel.
    pub(super) kernel: [usize; 2],
    /// Distance from a row to the next.
    pub(super) row_pitch: usize,
    /// Distance between channels of a pixel: 1 in nChw16c.
    pub(super) channel_pitch: usize,
    /// First of the cache lines of weights to prefetch during the tile. They are requested one per
    /// channel: many requests at once would delay the loads of this tile.
    pub(super) prefetch: *const f32,
    /// Number of those lines.
    pub(super) prefetch_lines: usize,
}

/// Computes a tile of `N` neighbouring output pixels by `B` channel blocks and stores it at `to`,
/// whose blocks are `pitch` apart.
///
/// `PIXEL` is the distance between neighbouring input pixels in `f32`: 16 in nChw16c, 1 in nchw.
/// Weights are packed as `[block][ky][kx][channel][B * 16]`.
///
/// # Safety
/// The processor has the instructions of `V`. Readable are the window of `N` pixels `STRIDE` apart
/// from `from` on, its weights, and 16 values of the bias for each block; writable are `N` pixels
/// of `B` blocks, `pitch` apart, from `to` on; readable is as much of the residual, if there is
/// one.
#[inline(always)]
pub(super) unsafe fn tile<
    V: Lanes,
    const N: usize,
    const B: usize,
    const STRIDE: usize,
    const PIXEL: usize,
>(
    window: &InputWindow,
    from: *const f32,
    mut weights: *const f32,
    init: AccumulatorInit,
    (to, pitch): (*mut f32, usize),
    epilogue: Option<&Epilogue>,
) {
    // SAFETY: the caller's; every offset below is of a pixel, a weight or a sum that is named
    // there.
    unsafe {
        let mut sums = [[V::splat(0.0); B]; N];
        match init {
            AccumulatorInit::Zero => {}
            AccumulatorInit::Bias(bias) => {
                let bias: [V; B] = std::array::from_fn(|block| V::load(bias.add(block * LANES)));
                sums = [bias; N];
            }
            AccumulatorInit::Dst => {
                // Sums of the chunks before are in the output.
                for (pixel, sums) in sums.iter_mut().enumerate() {
                    for (block, sum) in sums.iter_mut().enumerate() {
                        *sum = V::load(to.add(block * pitch + pixel * LANES));
                    }
                }
            }
        }
        // A constant of the compiled tile in nChw16c.
        let channel_pitch = if PIXEL == LANES { 1 } else { window.channel_pitch };
        let mut fetched = 0;
        for block in 0..window.blocks {
            let channels = if block + 1 == window.blocks { window.last_channels } else { LANES };
            for ky in 0..window.kernel[0] {
                for kx in 0..window.kernel[1] {
                    let from =
                        from.add(block * window.block_pitch + ky * window.row_pitch + kx * PIXEL);
                    for channel in 0..channels {
                        let from = from.add(channel * channel_pitch);
                        // A line at each channel, spread over the arithmetic that hides it.
                        if fetched < window.prefetch_lines {
                            V::prefetch(window.prefetch.wrapping_add(fetched * LANES));
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
        if let Some(epilogue) = epilogue {
            if !epilogue.residual.is_null() {
                for (pixel, sums) in sums.iter_mut().enumerate() {
                    for (block, sum) in sums.iter_mut().enumerate() {
                        let at = block * epilogue.residual_pitch + pixel * LANES;
                        *sum = sum.add(V::load(epilogue.residual.add(at)));
                    }
                }
            }
            for sums in &mut sums {
                for sum in sums {
                    *sum = activated(*sum, epilogue.activation);
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

/// Applies an activation to a vector.
///
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
