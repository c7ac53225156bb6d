//! Images as the world brings them, channel by channel, and a convolution of them.
//!
//! In blocks of sixteen channels an image of two takes eight times its size, and a convolution into
//! three uses three of sixteen lanes. Sixteen neighbouring pixels of a plane use all of them.

use std::ops::Range;

use super::conv::{ConvShape, Output};
use super::packed::{HeldMut, To};
use super::thread_pool::ThreadPool;
use super::tile::{Activation, activated};
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Channels of an output that are made together, at most.
const CHANNELS: usize = 4;

/// An image `[channels][height][width]` with a border of zeros around every plane.
#[derive(Debug, Clone)]
pub struct Planes {
    size: [usize; 3],
    border: usize,
    values: Vec<f32>,
}

impl Planes {
    /// Of zeros, of so many channels, rows and columns.
    pub fn zeros(size: [usize; 3], border: usize) -> Self {
        let mut planes = Self { size, border, values: Vec::new() };
        planes.values = vec![0.0; size[0] * planes.pitch() + LANES];
        planes
    }

    /// Channels, rows and columns.
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// Zeros on each side.
    pub fn border(&self) -> usize {
        self.border
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }

    /// Writes `factor * planes + offset` of `[channels][height][width]`.
    ///
    /// # Panics
    /// If there are more or fewer values.
    pub fn read(&mut self, thread_pool: &ThreadPool, level: Level, planes: &[f32], by: [f32; 2]) {
        let [channels, height, _] = self.size;
        assert_eq!(planes.len(), self.size.iter().product(), "planes of this size");
        let (row_pitch, block_pitch) = (self.row_pitch(), self.pitch());
        let first = self.place(0, 0);
        let pixels = self.values[first..].as_mut_ptr();
        let to = Output { pixels, row_pitch, block_pitch, width: self.size[2] };
        thread_pool.run(&|part| {
            let work = Reading { planes, by, height, to, units: part.chunk(channels * height) };
            // SAFETY: sizes were compared, rows of the parts are disjoint, and the level is one of
            // this processor's.
            unsafe { level.run(&work) };
        });
    }

    /// The least and the largest value.
    pub fn extremes(&self) -> [f32; 2] {
        let [channels, height, width] = self.size;
        let rows = (0..channels * height).map(|row| self.place(row / height, row % height));
        let values = rows.flat_map(|first| &self.values[first..first + width]);
        values.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], value| {
            [low.min(*value), high.max(*value)]
        })
    }

    /// The first pixel, and how far it is to the next row and to the next plane.
    pub(super) fn first(&self) -> (*const f32, usize, usize) {
        (self.values[self.place(0, 0)..].as_ptr(), self.row_pitch(), self.pitch())
    }

    /// From a row to the next.
    fn row_pitch(&self) -> usize {
        self.size[2] + 2 * self.border
    }

    /// From a plane to the next.
    fn pitch(&self) -> usize {
        (self.size[1] + 2 * self.border) * self.row_pitch()
    }

    /// Where a row begins.
    fn place(&self, channel: usize, y: usize) -> usize {
        channel * self.pitch() + (y + self.border) * self.row_pitch() + self.border
    }
}

/// Some rows, plane after plane, that are read.
struct Reading<'a> {
    planes: &'a [f32],
    by: [f32; 2],
    height: usize,
    to: Output,
    units: Range<usize>,
}

impl Kernel for Reading<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        let width = self.to.width;
        for unit in self.units.clone() {
            let at =
                unit / self.height * self.to.block_pitch + unit % self.height * self.to.row_pitch;
            let row = &self.planes[unit * width..][..width];
            // SAFETY: the caller's; the row is inside both.
            unsafe {
                let [factor, offset] = self.by.map(|value| V::splat(value));
                for (first, values) in row.chunks(LANES).enumerate() {
                    let to = self.to.pixels.add(at + first * LANES);
                    if values.len() == LANES {
                        V::load(values.as_ptr()).mul_add(factor, offset).store(to);
                    } else {
                        let mut last = [0.0; LANES];
                        last[..values.len()].copy_from_slice(values);
                        let last = V::load(last.as_ptr()).mul_add(factor, offset).array();
                        to.copy_from(last.as_ptr(), values.len());
                    }
                }
            }
        }
    }
}

/// A convolution of stride 1 of a few planes into a few channels.
#[derive(Debug, Clone)]
pub struct PlaneConv {
    shape: ConvShape,
    level: Level,
    /// `[channels_in][kernel][kernel][channels_out]`.
    weights: Vec<f32>,
    bias: Vec<f32>,
}

impl PlaneConv {
    /// Whether it can do one.
    pub fn can(shape: ConvShape) -> bool {
        let has_few = (1..=CHANNELS).contains(&shape.channels_out) && shape.channels_in <= CHANNELS;
        has_few && shape.stride == 1 && shape.kernel % 2 == 1
    }

    /// Of `weight`, `[channels_out][channels_in][kernel][kernel]`, and `bias`, `[channels_out]`.
    ///
    /// # Panics
    /// If there are more or fewer, or it [cannot](Self::can).
    pub fn new(shape: ConvShape, weight: &[f32], bias: &[f32], level: Level) -> Self {
        let ConvShape { channels_in, channels_out, kernel, .. } = shape;
        assert!(Self::can(shape), "a few channels and stride 1");
        let taps = channels_in * kernel * kernel;
        assert_eq!(weight.len(), channels_out * taps, "weights");
        assert_eq!(bias.len(), channels_out, "bias");
        let of_tap =
            |tap: usize| (0..channels_out).map(move |channel| weight[channel * taps + tap]);
        Self { shape, level, weights: (0..taps).flat_map(of_tap).collect(), bias: bias.to_vec() }
    }

    /// Its shape.
    pub fn shape(&self) -> ConvShape {
        self.shape
    }

    /// Writes `activation(conv(input))` to `output`, of which only the channels that there are:
    /// those that fill the block up are as they were.
    ///
    /// # Panics
    /// If an image has another size, or the border of the input is narrower than the padding.
    pub fn run(
        &self,
        thread_pool: &ThreadPool,
        input: &Planes,
        activation: Activation,
        mut output: HeldMut<'_>,
    ) {
        let [channels, height, width] = input.size;
        assert_eq!(channels, self.shape.channels_in, "channels of the input");
        assert!(input.border >= self.shape.padding(), "a border as wide as the padding");
        assert_eq!(output.size(), [self.shape.channels_out, height, width], "size of the output");
        let to = output.to();
        thread_pool.run(&|part| {
            let to = Written::Blocks(to);
            let work = Rows { conv: self, input, activation, to, rows: part.chunk(height) };
            // SAFETY: sizes were compared, rows of the parts are disjoint, and the level is one of
            // this processor's.
            unsafe { self.level.run(&work) };
        });
    }

    /// Writes some rows to those of `out`, in planes.
    ///
    /// # Safety
    /// They are inside the input, and writable.
    pub(super) unsafe fn rows(
        &self,
        input: &Planes,
        activation: Activation,
        out: Output,
        rows: Range<usize>,
    ) {
        let work = Rows { conv: self, input, activation, to: Written::Planes(out), rows };
        // SAFETY: the caller's.
        unsafe { self.level.run(&work) };
    }
}

/// Where outputs go.
#[derive(Clone, Copy)]
enum Written {
    Blocks(To),
    Planes(Output),
}

/// Some rows.
struct Rows<'a> {
    conv: &'a PlaneConv,
    input: &'a Planes,
    activation: Activation,
    to: Written,
    rows: Range<usize>,
}

impl Kernel for Rows<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        // SAFETY: the caller's.
        unsafe {
            match self.conv.shape.channels_out {
                1 => self.channels::<V, 1>(),
                2 => self.channels::<V, 2>(),
                3 => self.channels::<V, 3>(),
                _ => self.channels::<V, CHANNELS>(),
            }
        }
    }
}

impl Rows<'_> {
    /// # Safety
    /// That of [`Kernel::run`], of `C` channels.
    #[inline(always)]
    unsafe fn channels<V: Lanes, const C: usize>(&self) {
        let ConvShape { channels_in, kernel, .. } = self.conv.shape;
        let [_, _, width] = self.input.size;
        for y in self.rows.clone() {
            for x in (0..width).step_by(LANES) {
                // SAFETY: the caller's. A tap of the last of sixteen pixels may be on the next row,
                // or behind the last of all, where there are sixteen values more; its sum is not
                // kept.
                unsafe {
                    let mut sums: [V; C] = std::array::from_fn(|c| V::splat(self.conv.bias[c]));
                    let mut weights = self.conv.weights.as_ptr();
                    for channel in 0..channels_in {
                        let first = self.input.place(channel, y) + x;
                        let corner = first - (self.input.row_pitch() + 1) * (kernel / 2);
                        let from = self.input.values.as_ptr().add(corner);
                        for ky in 0..kernel {
                            for kx in 0..kernel {
                                let value = V::load(from.add(ky * self.input.row_pitch() + kx));
                                for (c, sum) in sums.iter_mut().enumerate() {
                                    *sum = value.mul_add(V::splat(*weights.add(c)), *sum);
                                }
                                weights = weights.add(C);
                            }
                        }
                    }
                    for (c, sum) in sums.into_iter().enumerate() {
                        let value = activated(sum, self.activation);
                        let count = LANES.min(width - x);
                        match self.to {
                            Written::Blocks(to) => {
                                to.scatter(value, to.at(0, y) + x * LANES + c, count);
                            }
                            Written::Planes(out) => {
                                let at = c * out.block_pitch + y * out.row_pitch + x;
                                let to = out.pixels.wrapping_add(at);
                                if count == LANES {
                                    value.store(to);
                                } else {
                                    to.copy_from(value.array().as_ptr(), count);
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::blocked::Image;
    use crate::blocked::tests::{
        After, activations, apart, convolved, image, magnitude, noise, planes,
    };

    proptest! {
        #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

        #[test]
        fn planes_are_convolved_as_by_plain_loops(
            seed in any::<u64>(),
            channels_in in 1_usize..=4,
            channels_out in 1_usize..=4,
            half in 0_usize..=2,
            (height, width) in (1_usize..9, 1_usize..40),
            (threads, activation) in (1_usize..4, activations()),
        ) {
            let shape = ConvShape { channels_in, channels_out, kernel: 2 * half + 1, stride: 1 };
            let size = [height, width];
            let values = noise(seed, channels_in * height * width);
            let weight = noise(seed ^ 1, channels_out * channels_in * shape.kernel.pow(2));
            let bias = noise(seed ^ 2, channels_out);
            let shown: Vec<f32> = values.iter().map(|value| 2.0 * value - 0.5).collect();
            let after = After { bias: &bias, residual: None, activation };
            let truth = after.applied(convolved(shape, &shown, size, &weight));
            let most = 1e-6 * magnitude(shape, &shown, size, &weight);
            let mut input = Planes::zeros([channels_in, height, width], half);
            for level in Level::available() {
                let conv = PlaneConv::new(shape, &weight, &bias, level);
                input.read(&ThreadPool::new(threads), level, &values, [2.0, -0.5]);
                let mut output = Image::zeros(channels_out, height, width, 1);
                conv.run(&ThreadPool::new(threads), &input, activation, HeldMut::Whole(&mut output));
                let difference = apart(&planes(&output), &truth);
                prop_assert!(difference < most, "{level}: {difference}");
                let alone = image(&planes(&output), channels_out, size, 1);
                prop_assert_eq!(alone.lines(), output.lines());
            }
        }
    }

    #[test]
    fn extremes_are_those_of_values() {
        let mut planes = Planes::zeros([2, 3, 5], 1);
        let values: Vec<f32> = (1..=30).map(|value| value as f32).collect();
        planes.read(&ThreadPool::new(1), Level::best(), &values, [1.0, 0.0]);
        assert_eq!(planes.extremes(), [1.0, 30.0]);
    }
}
