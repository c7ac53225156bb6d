//! Binary sum, channel gather and flatten.

use std::ops::Range;

use super::ThreadPool;
use super::image::Image;
use super::tile::{Activation, activated};
use super::views::F32Dst;
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Writes `activation(a + b)` to `output`; without `b`, `activation(a)`.
///
/// # Panics
/// If sizes differ.
pub fn add(
    thread_pool: &ThreadPool,
    level: Level,
    a: &Image,
    b: Option<&Image>,
    activation: Activation,
    output: &mut Image,
) {
    assert_same_size(a, output);
    b.iter().for_each(|b| assert_same_size(a, b));
    let rows_per_block = output.height();
    let rows = output.blocks() * rows_per_block;
    let dst = output.dst();
    thread_pool.run(&|part| {
        let kernel = AddRows { a, b, activation, dst, rows_per_block, rows: part.chunk(rows) };
        // SAFETY: images are of one size, rows of the parts are disjoint, and the level is one of
        // this processor's.
        unsafe { level.run(&kernel) };
    });
}

fn assert_same_size(a: &Image, b: &Image) {
    let size = |image: &Image| [image.channels(), image.height(), image.width()];
    assert_eq!(size(a), size(b), "images of one size");
}

/// Kernel over a range of rows, counted over all channel blocks.
struct AddRows<'a> {
    a: &'a Image,
    b: Option<&'a Image>,
    activation: Activation,
    dst: F32Dst,
    rows_per_block: usize,
    rows: Range<usize>,
}

impl Kernel for AddRows<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        for row in self.rows.clone() {
            let (block, y) = (row / self.rows_per_block, row % self.rows_per_block);
            let a = self.a.tap(block, y, 0, 0);
            let b = self.b.map(|b| b.tap(block, y, 0, 0));
            // SAFETY: the caller's.
            unsafe {
                let to = self.dst.pixel(block, y, 0);
                for at in (0..self.dst.width).map(|x| x * LANES) {
                    let mut sum = V::load(a.add(at));
                    if let Some(b) = b {
                        sum = sum.add(V::load(b.add(at)));
                    }
                    activated(sum, self.activation).store(to.add(at));
                }
            }
        }
    }
}

/// Copies to each channel `k` of `output` the channel of the image that `source(k)` returns.
/// Slicing and interleaving of channels (ShuffleNet's channel shuffle) are gathers.
///
/// # Panics
/// If heights or widths differ or a source has no such channel.
pub fn gather_channels<'a>(output: &mut Image, source: impl Fn(usize) -> (&'a Image, usize)) {
    let (height, width) = (output.height(), output.width());
    for channel in 0..output.channels() {
        let (image, from) = source(channel);
        assert_eq!([image.height(), image.width()], [height, width], "images of one size");
        assert!(from < image.channels(), "channel {from} of {}", image.channels());
        for y in 0..height {
            let (to, to_lane) = output.position(channel, y, 0);
            let (from, from_lane) = image.position(from, y, 0);
            // A channel is one lane of every line: values are copied with the stride of a block.
            let lines = output.lines_mut()[to..to + width].iter_mut();
            for (to, from) in lines.zip(&image.lines()[from..from + width]) {
                to.0[to_lane] = from.0[from_lane];
            }
        }
    }
}

/// Copies the channels of several images, one image after the other.
///
/// # Panics
/// If the images differ in size, or have together fewer channels than the output.
pub fn concat(inputs: &[&Image], output: &mut Image) {
    let sources: Vec<(&Image, usize)> = inputs
        .iter()
        .flat_map(|image| (0..image.channels()).map(|channel| (*image, channel)))
        .collect();
    gather_channels(output, |channel| sources[channel]);
}

/// Copies all values of `input`, in nchw order, to the channels of the single pixel of `output`.
///
/// # Panics
/// If `output` has another number of channels than `input` has values, or more than one pixel.
pub fn flatten(input: &Image, output: &mut Image) {
    assert_eq!([output.height(), output.width()], [1, 1], "a single pixel");
    let mut values = vec![0.0; output.channels()];
    input.copy_to_nchw(&mut values);
    output.copy_from_nchw(&values);
}
