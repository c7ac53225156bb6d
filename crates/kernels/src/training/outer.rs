//! The kernel of gradients by weights: products of channels of the input and channels of the
//! gradient, summed over pixels in registers.

use crate::simd::{LANES, Lanes};

/// The pixels over which products are summed. Distances are in `f32`.
#[derive(Clone, Copy)]
pub(super) struct Pixels {
    /// Columns, rows and images.
    pub(super) size: [usize; 3],
    /// Distances between neighbours of each kind, of the input and of the gradient.
    pub(super) from_pitch: [usize; 3],
    pub(super) gradient_pitch: [usize; 3],
    /// Distance between blocks of channels of the gradient.
    pub(super) block_pitch: usize,
}

/// Input channels, at arbitrary offsets, that are multiplied at once.
pub(super) const OFFSETS: usize = 8;

/// Adds to `to`, `[channel][block][16]`, the products of eight input channels with one or two
/// blocks of the gradient, summed over pixels.
///
/// # Safety
/// The processor has the instructions of `V`. Readable are, for every pixel, each of `offsets` from
/// `from` on and `blocks` blocks from `gradient` on; writable are `8 * blocks * 16` sums.
#[inline(always)]
pub(super) unsafe fn outer<V: Lanes>(
    pixels: &Pixels,
    from: *const f32,
    offsets: &[usize; OFFSETS],
    gradient: *const f32,
    blocks: usize,
    to: *mut f32,
) {
    // As many sums as registers hold.
    const { assert!(OFFSETS.is_multiple_of(4)) };
    // SAFETY: the caller's.
    unsafe {
        match (blocks, V::TILE[1] >= 12) {
            (2, true) => sums::<V, OFFSETS, 2>(pixels, from, offsets, gradient, to),
            (_, true) => sums::<V, OFFSETS, 1>(pixels, from, offsets, gradient, to),
            (_, false) => {
                // Fewer registers: four channels and one block at a time.
                for (k, offsets) in offsets.as_chunks::<4>().0.iter().enumerate() {
                    for block in 0..blocks {
                        let gradient = gradient.add(block * pixels.block_pitch);
                        let mut part = [0.0; 4 * LANES];
                        sums::<V, 4, 1>(pixels, from, offsets, gradient, part.as_mut_ptr());
                        for (channel, part) in part.as_chunks::<LANES>().0.iter().enumerate() {
                            let to = to.add(((4 * k + channel) * blocks + block) * LANES);
                            V::load(to).add(V::load(part.as_ptr())).store(to);
                        }
                    }
                }
            }
        }
    }
}

/// # Safety
/// That of [`outer`], for `M` offsets and `B` blocks.
#[inline(always)]
unsafe fn sums<V: Lanes, const M: usize, const B: usize>(
    pixels: &Pixels,
    from: *const f32,
    offsets: &[usize; M],
    gradient: *const f32,
    to: *mut f32,
) {
    let [columns, rows, images] = pixels.size;
    // SAFETY: the caller's; every offset below is of a pixel or a sum that is named there.
    unsafe {
        // In registers for all pixels: memory is touched once before and once after.
        let mut sums: [[V; B]; M] = std::array::from_fn(|channel| {
            std::array::from_fn(|block| V::load(to.add((channel * B + block) * LANES)))
        });
        for (image, y) in (0..images).flat_map(|image| (0..rows).map(move |y| (image, y))) {
            let place = |pitch: [usize; 3]| y * pitch[1] + image * pitch[2];
            let from: [*const f32; M] = {
                let from = from.add(place(pixels.from_pitch));
                std::array::from_fn(|channel| from.add(offsets[channel]))
            };
            let gradient = gradient.add(place(pixels.gradient_pitch));
            let (mut at, mut at_gradient) = (0, 0);
            for _ in 0..columns {
                let gradient = gradient.add(at_gradient);
                let dy: [V; B] =
                    std::array::from_fn(|block| V::load(gradient.add(block * pixels.block_pitch)));
                for (sums, from) in sums.iter_mut().zip(from) {
                    let value = V::splat(*from.add(at));
                    for (sum, dy) in sums.iter_mut().zip(dy) {
                        *sum = value.mul_add(dy, *sum);
                    }
                }
                at += pixels.from_pitch[0];
                at_gradient += pixels.gradient_pitch[0];
            }
        }
        for (channel, sums) in sums.iter().enumerate() {
            for (block, sum) in sums.iter().enumerate() {
                sum.store(to.add((channel * B + block) * LANES));
            }
        }
    }
}
