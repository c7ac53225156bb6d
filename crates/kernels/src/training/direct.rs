//! Convolution as the sum that it is, of padded copies of images.

use rayon::prelude::*;

use super::blocks::Blocks;
use super::conv::Conv;
use super::gather::Gather;
use super::norm::Input;
use super::outer::{Pixels, TOGETHER, outer};
use super::padded::{Padded, Pitches, pad};
use super::weights::Weights;
use crate::blocked::{Line, blocks_of, groups};
use crate::simd::{Kernel, LANES, Lanes};

/// Pixels for which weights are fetched once, if there are as many images.
const PIXELS: usize = 512;
/// Pixels whose gradients stay in the nearest cache while channels and taps of the input go by.
const NEAR: usize = 96;
/// Lines of padded images that are held for the gradient by the weight: 8 MiB.
const HELD_LINES: usize = (8 << 20) / size_of::<Line>();

/// Images that a thread takes at a time. Does not change any sum.
fn at_once(shape: &Blocks) -> usize {
    let pixels = (shape.height * shape.width).max(1);
    let share = shape.batch.div_ceil(rayon::current_num_threads());
    PIXELS.div_ceil(pixels).clamp(1, share.max(1))
}

pub(super) fn forward(
    conv: &Conv,
    input: Input<'_>,
    weights: Weights<'_>,
    bias: Option<&[f32]>,
) -> Vec<f32> {
    let (shape, out) = (conv.input, conv.output());
    let pitches = Pitches::of(&shape, conv.kernel / 2);
    let all: Vec<usize> = (0..conv.kernel.pow(2)).collect();
    let offset = |tap: &usize| tap / conv.kernel * pitches.row + tap % conv.kernel * LANES;
    let taps: Vec<usize> = all.iter().map(offset).collect();
    let weights = weights.packed(&all, conv.together());
    let bias = bias.map(blocks_of);
    let mut output = vec![0.0; out.numbers()];
    if output.is_empty() {
        return output;
    }
    let images = at_once(&out);
    let sources = input.values.par_chunks(images * shape.image());
    output.par_chunks_mut(images * out.image()).zip(sources).for_each_init(
        Padded::default,
        |padded, (to, values)| {
            let images = values.len() / shape.image();
            let padded = padded.room(pitches.lines(images));
            let copies = padded.chunks_exact_mut(pitches.lines(1));
            for (copy, values) in copies.zip(values.chunks_exact(shape.image())) {
                pad(&shape, Input { values, ..input }, pitches, copy);
            }
            let work = Gather {
                taps: &taps,
                channels: shape.channels,
                block_pitch: pitches.block,
                from_pitch: [conv.stride * LANES, conv.stride * pitches.row, pitches.image],
                weights: &weights,
                bias: bias.as_deref(),
                channels_out: out.channels,
                together: conv.together(),
                block_pitch_out: out.block(),
                size: [out.width, out.height, images],
                to_pitch: [LANES, out.width * LANES, out.image()],
                from: padded.as_ptr().cast(),
                to: to.as_mut_ptr(),
            };
            // SAFETY: taps of every output are inside of the padded image, since its border is half a
            // kernel wide, and outputs are those of these images.
            unsafe { conv.level.run(&work) };
        },
    );
    output
}

/// Of stride 2, pixels of even and of odd rows and columns have gradients of their own taps.
pub(super) fn backward_input(conv: &Conv, weights: Weights<'_>, gradient: &[f32]) -> Vec<f32> {
    let (shape, out, stride) = (conv.input, conv.output(), conv.stride);
    let border = conv.kernel / 2;
    let pitches = Pitches::of(&out, border);
    let phases: Vec<_> = (0..stride * stride)
        .map(|phase| Phase::new(conv, [phase / stride, phase % stride], pitches, weights))
        .filter(|phase| !phase.taps.is_empty() && phase.size.iter().all(|side| *side > 0))
        .collect();
    let mut input = vec![0.0; shape.numbers()];
    if input.is_empty() {
        return input;
    }
    let images = at_once(&out);
    let sources = gradient.par_chunks(images * out.image());
    input.par_chunks_mut(images * shape.image()).zip(sources).for_each_init(
        Padded::default,
        |padded, (to, values)| {
            let images = values.len() / out.image();
            let padded = padded.room(pitches.lines(images));
            let copies = padded.chunks_exact_mut(pitches.lines(1));
            for (copy, values) in copies.zip(values.chunks_exact(out.image())) {
                pad(&out, values.into(), pitches, copy);
            }
            for phase in &phases {
                let [y, x] = phase.place;
                let work = Gather {
                    taps: &phase.taps,
                    channels: out.channels,
                    block_pitch: pitches.block,
                    from_pitch: [LANES, pitches.row, pitches.image],
                    weights: &phase.weights,
                    bias: None,
                    channels_out: shape.channels,
                    together: conv.together(),
                    block_pitch_out: shape.block(),
                    size: [phase.size[1], phase.size[0], images],
                    to_pitch: [stride * LANES, stride * shape.width * LANES, shape.image()],
                    from: padded.as_ptr().cast(),
                    to: to[(y * shape.width + x) * LANES..].as_mut_ptr(),
                };
                // SAFETY: no tap is further than half a kernel from a pixel of the gradient, which is as
                // wide as the border; pixels of the phase are inside of these images.
                unsafe { conv.level.run(&work) };
            }
        },
    );
    input
}

/// Pixels of the input that the same taps reach.
struct Phase {
    /// Row and column of the first.
    place: [usize; 2],
    /// Rows and columns of them.
    size: [usize; 2],
    /// Where their gradients are in the padded image.
    taps: Vec<usize>,
    weights: Vec<Line>,
}

impl Phase {
    fn new(conv: &Conv, place: [usize; 2], pitches: Pitches, weights: Weights<'_>) -> Self {
        let (kernel, stride) = (conv.kernel, conv.stride);
        let border = kernel / 2;
        // Output `(place + border - k) / stride` sees the pixel through tap `k`, if that is whole.
        let seen = |place: usize, k: usize| {
            let apart = place + border + stride * kernel - k;
            apart.is_multiple_of(stride).then(|| border + apart / stride - kernel)
        };
        let mut taps = Vec::new();
        let mut which = Vec::new();
        for tap in 0..kernel * kernel {
            if let (Some(y), Some(x)) = (seen(place[0], tap / kernel), seen(place[1], tap % kernel))
            {
                taps.push(y * pitches.row + x * LANES);
                which.push(tap);
            }
        }
        let Blocks { height, width, .. } = conv.input;
        let size = [height, width].into_iter().zip(place);
        let size: Vec<_> =
            size.map(|(side, place)| side.saturating_sub(place).div_ceil(stride)).collect();
        let weights = weights.packed(&which, conv.together());
        Self { place, size: [size[0], size[1]], taps, weights }
    }
}

pub(super) fn backward_weight(conv: &Conv, input: Input<'_>, gradient: &[f32]) -> Vec<f32> {
    let (shape, out, kernel) = (conv.input, conv.output(), conv.kernel);
    let pitches = Pitches::of(&shape, kernel / 2);
    let together = conv.together();
    let groups: Vec<_> = groups(out.channels, together).collect();
    // Sums of a row of the kernel: `[column and channel][block][16]`.
    let of_row = kernel * LANES * together;
    let mut sums = vec![Line::ZERO; groups.len() * shape.blocks() * kernel * of_row];
    let images = (HELD_LINES / pitches.lines(1).max(1)).clamp(1, shape.batch.max(1));
    let mut padded = Padded::default();
    let rounds = input.values.chunks(images * shape.image().max(1));
    for (values, gradient) in rounds.zip(gradient.chunks(images * out.image().max(1))) {
        let images = values.len() / shape.image();
        let padded = padded.room(pitches.lines(images));
        let sources = values.par_chunks_exact(shape.image());
        padded.par_chunks_exact_mut(pitches.lines(1)).zip(sources).for_each(|(copy, values)| {
            pad(&shape, Input { values, ..input }, pitches, copy);
        });
        let padded = &*padded;
        sums.par_chunks_mut(of_row).enumerate().for_each(|(k, sums)| {
            let (ky, rest) = (k % kernel, k / kernel);
            let (block, group) = (rest % shape.blocks(), &groups[rest / shape.blocks()]);
            let channels = LANES.min(shape.channels - block * LANES);
            let work = Row {
                pixels: Pixels {
                    size: [out.width, out.height, images],
                    from_pitch: [conv.stride * LANES, conv.stride * pitches.row, pitches.image],
                    gradient_pitch: [LANES, out.width * LANES, out.image()],
                    block_pitch: out.block(),
                },
                from: padded[(block * pitches.block + ky * pitches.row) / LANES..].as_ptr().cast(),
                gradient: gradient[group.start * out.block()..].as_ptr(),
                blocks: group.len(),
                columns: kernel,
                channels,
                sums: sums.as_mut_ptr().cast(),
            };
            // SAFETY: taps of every output are inside of the padded image; sums are as many as said.
            unsafe { conv.level.run(&work) };
        });
    }
    let mut weight = vec![0.0; out.channels * shape.channels * kernel * kernel];
    let of_channel = shape.channels * kernel * kernel;
    weight.par_chunks_mut(of_channel.max(1)).enumerate().for_each(|(channel, weight)| {
        let (group, lane) = (channel / LANES / together, channel % LANES);
        let (block_out, blocks) = (channel / LANES % together, groups[group].len());
        for (k, value) in weight.iter_mut().enumerate() {
            let (from, ky, kx) = (k / (kernel * kernel), k / kernel % kernel, k % kernel);
            let (block, from) = (from / LANES, from % LANES);
            let channels = LANES.min(shape.channels - block * LANES);
            let row = ((group * shape.blocks() + block) * kernel + ky) * of_row;
            *value = sums[row + (kx * channels + from) * blocks + block_out].0[lane];
        }
    });
    weight
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
                    self.some::<V>(&pixels, from, gradient);
                }
            }
        }
    }
}

impl Row {
    /// Adds what some pixels come to.
    ///
    /// # Safety
    /// That of [`Kernel::run`], for these pixels.
    #[inline(always)]
    unsafe fn some<V: Lanes>(&self, pixels: &Pixels, from: *const f32, gradient: *const f32) {
        let count = self.columns * self.channels;
        for first in (0..count).step_by(TOGETHER) {
            // Beyond the last, the last again: what it comes to is not looked at.
            let offsets: [usize; TOGETHER] = std::array::from_fn(|k| {
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
