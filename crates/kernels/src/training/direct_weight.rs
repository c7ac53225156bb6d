//! The gradient by the weight of a direct convolution.
//!
//! Threads share the weights, not the images: each sums its rows of the kernel over all pixels in
//! one order.

use std::ops::Range;

use rayon::prelude::*;

use super::norm::NormalizedInput;
use super::outer::{OFFSETS, Pixels, outer};
use super::padded::{Padded, Pitches, pad};
use super::shape::Conv;
use crate::blocked::{Line, block_groups};
use crate::simd::{Kernel, LANES, Lanes};

/// Pixels whose gradients stay in the nearest cache while channels and taps of the input go by.
const NEAR: usize = 96;
/// Pieces of work into which the gradient is cut at least, if the batch allows it.
const MIN_PIECES: usize = 16;
/// Lines of padded images in memory: 8 MiB.
const PADDED_LINES: usize = (8 << 20) / size_of::<Line>();

pub(super) fn gradient(conv: &Conv, input: NormalizedInput<'_>, gradient: &[f32]) -> Vec<f32> {
    let (shape, out) = (conv.input, conv.output());
    let pitches = Pitches::new(&shape, conv.kernel / 2);
    let sums = RowSums::new(conv);
    let mut lines = vec![Line::ZERO; sums.parts * sums.of_part()];
    let images = (PADDED_LINES / pitches.lines(1).max(1)).clamp(1, shape.batch.max(1));
    let mut padded = Padded::default();
    let rounds = input.values.chunks(images * shape.image().max(1));
    for (values, gradient) in rounds.zip(gradient.chunks(images * out.image().max(1))) {
        let images = values.len() / shape.image();
        let padded = padded.room(pitches.lines(images));
        let sources = values.par_chunks_exact(shape.image());
        padded.par_chunks_exact_mut(pitches.lines(1)).zip(sources).for_each(|(copy, values)| {
            pad(&shape, NormalizedInput { values, ..input }, pitches, copy);
        });
        let padded = &*padded;
        lines.par_chunks_mut(sums.of_row).enumerate().for_each(|(k, lines)| {
            let Some(work) = sums.row(conv, k, images, pitches, padded, gradient, lines) else {
                return;
            };
            // SAFETY: taps of every output are inside of the padded image; sums are as many as
            // said.
            unsafe { conv.level.run(&work) };
        });
    }
    sums.weight(conv, &lines)
}

/// The layout of sums over pixels: `[part][group][block][row of the kernel]`, each of which holds
/// `[column and channel][output block of the group][16]`.
struct RowSums {
    /// Output blocks that are computed at once.
    groups: Vec<Range<usize>>,
    /// Parts of the batch that are summed apart. Their number depends on the shape alone.
    parts: usize,
    rows: usize,
    of_row: usize,
}

impl RowSums {
    fn new(conv: &Conv) -> Self {
        let at_once = conv.blocks_at_once();
        let groups: Vec<_> = block_groups(conv.channels_out, at_once).collect();
        let rows = groups.len() * conv.input.blocks() * conv.kernel;
        // Layers of few weights have too few rows for the threads of a desktop.
        let parts = (MIN_PIECES / rows.max(1)).clamp(1, conv.input.batch.max(1));
        Self { groups, parts, rows, of_row: conv.kernel * LANES * at_once }
    }

    fn of_part(&self) -> usize {
        self.rows * self.of_row
    }

    /// The work that adds the products of some images to the sums of index `k`; none without
    /// images.
    #[allow(clippy::too_many_arguments, reason = "one call, whose arguments are the loop's state")]
    fn row(
        &self,
        conv: &Conv,
        k: usize,
        images: usize,
        pitches: Pitches,
        padded: &[Line],
        gradient: &[f32],
        sums: &mut [Line],
    ) -> Option<Row> {
        let (shape, out) = (conv.input, conv.output());
        // Parts of the batch have sums of their own, so that threads need not wait for each other.
        let of_part = images.div_ceil(self.parts);
        let first = k / self.rows * of_part;
        let images = images.min(first + of_part).checked_sub(first).filter(|images| *images > 0)?;
        let (ky, rest) = (k % conv.kernel, k % self.rows / conv.kernel);
        let (block, group) = (rest % shape.blocks(), &self.groups[rest / shape.blocks()]);
        let from = first * pitches.image + block * pitches.block + ky * pitches.row;
        Some(Row {
            pixels: Pixels {
                size: [out.width, out.height, images],
                from_pitch: [conv.stride * LANES, conv.stride * pitches.row, pitches.image],
                gradient_pitch: [LANES, out.width * LANES, out.image()],
                block_pitch: out.block(),
            },
            from: padded[from / LANES..].as_ptr().cast(),
            gradient: gradient[first * out.image() + group.start * out.block()..].as_ptr(),
            blocks: group.len(),
            columns: conv.kernel,
            channels: LANES.min(shape.channels - block * LANES),
            sums: sums.as_mut_ptr().cast(),
        })
    }

    /// The gradient by the weight, in the weight's own layout.
    fn weight(&self, conv: &Conv, lines: &[Line]) -> Vec<f32> {
        let (shape, kernel) = (conv.input, conv.kernel);
        let mut weight = vec![0.0; conv.weight_count()];
        let of_channel = shape.channels * kernel * kernel;
        weight.par_chunks_mut(of_channel.max(1)).enumerate().for_each(|(channel, weight)| {
            let (block, lane) = (channel / LANES, channel % LANES);
            let at_once = conv.blocks_at_once();
            let (group, block_out) = (block / at_once, block % at_once);
            let blocks = self.groups[group].len();
            for (k, value) in weight.iter_mut().enumerate() {
                let (from, ky, kx) = (k / (kernel * kernel), k / kernel % kernel, k % kernel);
                let (block, from) = (from / LANES, from % LANES);
                let channels = LANES.min(shape.channels - block * LANES);
                let row = ((group * shape.blocks() + block) * kernel + ky) * self.of_row;
                let line = row + (kx * channels + from) * blocks + block_out;
                // Parts are added in their order, so that no bit depends on the number of threads.
                let parts = lines[line..].iter().step_by(self.of_part());
                *value = parts.map(|line| line.0[lane]).sum();
            }
        });
        weight
    }
}

/// The gradient by a row of the kernel and a block of channels.
struct Row {
    pixels: Pixels,
    from: *const f32,
    gradient: *const f32,
    /// Blocks of the gradient.
    blocks: usize,
    /// Columns of the kernel.
    columns: usize,
    channels: usize,
    sums: *mut f32,
}

impl Kernel for Row {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let [columns, rows, images] = self.pixels.size;
        // So few that gradients stay in the nearest cache while channels and taps go by.
        let rows_at_once = (NEAR / columns).clamp(1, rows);
        let images_at_once = (NEAR / (columns * rows)).clamp(1, images);
        for image in (0..images).step_by(images_at_once) {
            for row in (0..rows).step_by(rows_at_once) {
                let (rows, images) =
                    (rows_at_once.min(rows - row), images_at_once.min(images - image));
                let pixels = Pixels { size: [columns, rows, images], ..self.pixels };
                let place = |pitch: [usize; 3]| row * pitch[1] + image * pitch[2];
                // SAFETY: the caller's; these pixels are among all.
                unsafe {
                    let from = self.from.add(place(pixels.from_pitch));
                    let gradient = self.gradient.add(place(pixels.gradient_pitch));
                    self.add_pixels::<V>(&pixels, from, gradient);
                }
            }
        }
    }
}

impl Row {
    /// Adds the products of some pixels.
    ///
    /// # Safety
    /// That of [`Kernel::run`], for these pixels.
    #[inline(always)]
    unsafe fn add_pixels<V: Lanes>(&self, pixels: &Pixels, from: *const f32, gradient: *const f32) {
        let count = self.columns * self.channels;
        for first in (0..count).step_by(OFFSETS) {
            // The last offset pads the chunk; its extra sums are never read.
            let offsets: [usize; OFFSETS] = std::array::from_fn(|k| {
                let k = (first + k).min(count - 1);
                k / self.channels * LANES + k % self.channels
            });
            // SAFETY: the caller's; there is room for all columns of sixteen channels.
            unsafe {
                let sums = self.sums.add(first * self.blocks * LANES);
                outer::<V>(pixels, from, &offsets, gradient, self.blocks, sums);
            }
        }
    }
}
